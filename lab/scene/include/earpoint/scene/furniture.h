#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/scene/scene.h>
#include <earpoint/scene/scene_builder.h>
#include <earpoint/scene/texture.h>

namespace earpoint {

enum class FurnitureKind {
  sofa,
  armchair,
  coffee_table,
  tv_stand,
  television,
  bookcase,
  shelf,
  rug,
  floor_lamp,
  table_lamp,
  ceiling_lamp,
  plant,
  piano,
  dining_table,
  chair,
  stool,
  bed,
  bedside_table,
  wardrobe,
  dresser,
  desk,
  office_chair,
  computer,
  kitchen_base,
  kitchen_sink,
  stove,
  fridge,
  wall_cabinet,
  washing_machine,
  bathtub,
  toilet,
  washbasin,
  towel_rack,
  radiator,
  curtain,
  blinds,
  picture,
  mirror,
};

inline constexpr int kFurnitureKinds = static_cast<int>(FurnitureKind::mirror) + 1;

/// @return "sofa", "coffee table", ...
std::string_view name_of(FurnitureKind kind);

/// @return the kind of that name, if there is one
std::optional<FurnitureKind> furniture_kind(std::string_view name);

/// A piece of furniture to be placed: its front looks along x, its base stands on z = 0, the origin
/// is the middle of its base.
struct FurnitureModel {
  std::string name;
  FurnitureKind kind = FurnitureKind::sofa;
  Vector3 size_m;       ///< depth (x), width (y), height (z) of its box
  double base_m = 0.0;  ///< above the floor, for what hangs on walls
  Scene scene;          ///< mesh, materials and textures; the instances are not used
  std::string credit;   ///< author and licence, for the list of credits
};

/// The colours and stuffs that the furniture of one home has in common.
struct FurnitureStyle {
  std::uint64_t seed = 0;
  ScreenColour wood{0.62F, 0.45F, 0.3F};
  ScreenColour fabric{0.5F, 0.5F, 0.55F};
  ScreenColour accent{0.7F, 0.3F, 0.25F};
  ScreenColour bedding{0.4F, 0.5F, 0.6F};
  ScreenColour rug{0.5F, 0.25F, 0.25F};
  ScreenColour curtain{0.85F, 0.82F, 0.75F};
  bool leather = false;                         ///< upholstery
  std::string curtain_sound = "curtain_light";  ///< of the standard materials
};

FurnitureStyle draw_furniture_style(RandomStream& random);

/// Furniture that a home may use: models that were loaded, and a stand-in built of boxes for every
/// kind, so that nothing needs to be installed.
class FurnitureLibrary {
 public:
  /// Stand-ins alone.
  FurnitureLibrary() = default;
  explicit FurnitureLibrary(std::vector<FurnitureModel> models);

  [[nodiscard]] const std::vector<FurnitureModel>& models() const { return models_; }

  /// @return the models of a kind that are no larger than `limit_m` along any axis
  [[nodiscard]] std::vector<const FurnitureModel*> find(FurnitureKind kind,
                                                        const Vector3& limit_m) const;

 private:
  std::vector<FurnitureModel> models_;
};

/// A model, or a stand-in of a size.
struct FurniturePiece {
  FurnitureKind kind = FurnitureKind::sofa;
  const FurnitureModel* model = nullptr;  ///< null: a stand-in
  Vector3 size_m;                         ///< depth, width, height
};

/// Draws a piece: a model of the library where one fits, else a stand-in. With models of at most
/// `most_triangles`.
/// @param limit_m  the largest depth, width and height
/// @return nothing if even the smallest stand-in is larger than the limit
std::optional<FurniturePiece> draw_furniture(const FurnitureLibrary& library, FurnitureKind kind,
                                             const Vector3& limit_m, std::size_t most_triangles,
                                             RandomStream& random);

/// Adds a piece as a separate instance.
/// @return the instance's index
std::uint32_t add_furniture(const FurniturePiece& piece, const FurnitureStyle& style,
                            const Placement& placement, SceneBuilder& builder);

}  // namespace earpoint
