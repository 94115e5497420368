#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/pose.h>
#include <earpoint/scene/scene_builder.h>

namespace earpoint {

enum class Gender { female, male };
enum class Posture {
  standing,
  sitting,  ///< on a seat
  ground,   ///< on the floor
};

std::string_view name_of(Gender gender);
std::string_view name_of(Posture posture);
std::optional<Gender> gender_named(std::string_view name);
std::optional<Posture> posture_named(std::string_view name);

/// A person to be placed: the feet stand on z = 0, the head looks along x, the origin lies under
/// the middle of the head.
struct FigureModel {
  std::string name;
  Gender gender = Gender::female;
  Posture posture = Posture::standing;
  bool is_adult = true;
  bool for_test = false;  ///< kept for test scenes: people there were never seen in training
  Vector3 size_m;         ///< of its box, along x, y, z; the stool included
  Vector3 mouth_m;        ///< where speech comes from: 2 cm before the lips, in free air
  double seat_m = 0.0;    ///< height of the seat under a sitting person
  Scene scene;            ///< mesh, materials and textures; the instances are not used
  std::string credit;     ///< author and licence
};

/// Who of the figures may be used.
enum class FigureSplit { train, test };

/// People that conversations may use: figures that were loaded, and a stand-in of either gender and
/// each posture, so that nothing needs to be installed.
class FigureLibrary {
 public:
  /// Stand-ins alone.
  FigureLibrary();
  /// Stand-ins are taken only where no adult model has that gender and split.
  explicit FigureLibrary(std::vector<FigureModel> models);

  [[nodiscard]] const std::vector<FigureModel>& models() const { return models_; }

  /// Draws a figure among the adults of that gender, posture and split: voices are those of adults.
  /// If there is none of that posture, among those of the next one: who cannot sit on a seat sits
  /// on the floor, or the other way round, before anybody stands (of the installed figures kept for
  /// tests, no woman sits on a seat and no man on the floor).
  [[nodiscard]] const FigureModel& draw(Gender gender, Posture posture, FigureSplit split,
                                        RandomStream& random) const;

 private:
  std::vector<FigureModel> models_;
  std::vector<FigureModel> stand_ins_;
};

/// A person in a scene.
struct Person {
  std::string name;  ///< of the figure
  Gender gender = Gender::female;
  Posture posture = Posture::standing;
  Pose world_from_head;        ///< at the mouth; its front is where the person looks and speaks
  std::uint32_t instance = 0;  ///< index into Scene::instances
};

/// Adds a person to a finished scene as an instance of its own: body, clothes and, under a sitting
/// person, a stool.
/// @param x, y     on the floor, under the middle of the head, metres
/// @param yaw_rad  where the head looks; 0 is along x, counter-clockwise
Person add_person(const FigureModel& figure, double x, double y, double yaw_rad, Scene& scene);

}  // namespace earpoint
