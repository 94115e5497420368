#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/image.h>
#include <earpoint/record/session.h>
#include <earpoint/record/session_truth.h>
#include <earpoint/record/sync.h>

namespace earpoint {

/// Where a point is seen, from 0 to 1 of the picture; nothing behind the camera or beside it.
struct SeenPoint {
  double x = 0.0;
  double y = 0.0;
};
[[nodiscard]] std::optional<SeenPoint> project(const Vector3& point_m, const Lens& lens,
                                               const Pose& world_from_camera);

/// Where the people of a session are: in pictures by the session's boxes, in the room by the sound
/// of their near microphones.
class SeenPeople {
 public:
  /// @throws InputError if the table of boxes is malformed or names a camera or person that is not
  ///         there
  SeenPeople(const Session& session, const SyncResult& sync);

  /// Whose voice each microphone has, by index in Session::people: its owner's, unless the
  /// synchronisation found another wearer.
  [[nodiscard]] const std::vector<std::size_t>& wearers() const { return wearers_; }
  /// Where the mouth behind a microphone is around a session time, by its sound within a second,
  /// else by its nearest; nothing if it was never found.
  [[nodiscard]] std::optional<Vector3> mouth(std::size_t microphone, double time_s) const;

  /// The box of a microphone's wearer in a camera, at a session time: as the session tells it, else
  /// that of a body of usual size below the mouth; nothing where nobody is seen.
  [[nodiscard]] std::optional<Box> box(std::size_t microphone, std::size_t camera,
                                       double time_s) const;

  /// The box of a person by the session, at a session time; nullptr where they are not seen then.
  [[nodiscard]] const PersonBox* seen_box(std::size_t person, std::size_t camera,
                                          double time_s) const;

 private:
  struct Voice {
    double time_s = 0.0;
    Vector3 mouth_m;
  };
  [[nodiscard]] std::optional<Vector3> nearest_mouth(std::size_t microphone, double time_s) const;

  const Session& session_;
  std::vector<std::optional<DeviceClock>> clocks_;  ///< by camera
  std::vector<std::vector<Voice>> voices_;          ///< by microphone
  /// [camera][person], by time on the camera's clock.
  std::vector<std::vector<std::vector<PersonBox>>> boxes_;
  std::vector<double> box_ages_s_;  ///< by camera: how far from a time a box may be
  std::vector<std::size_t> wearers_;
};

}  // namespace earpoint
