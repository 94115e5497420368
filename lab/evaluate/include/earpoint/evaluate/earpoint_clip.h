#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/image.h>
#include <earpoint/pose.h>

namespace earpoint {

/// A place where it is known what the clip sounded like.
struct KnownEarpoint {
  std::string name;
  Pose source_from_target;
  double yaw_deg = 0.0;         ///< the same turn as in the pose
  std::filesystem::path truth;  ///< binaural sound, as long as the clip's
};

/// A picture from above in which the source view looks up the page.
struct MapPicture {
  std::filesystem::path picture;
  double camera_x = 0.0;  ///< where the source view stands, pixels from the left and top edge
  double camera_y = 0.0;
  double pixels_per_metre = 1.0;  ///< > 0
};

/// A recorded clip and what was heard at the same time in other places.
struct EarpointClip {
  std::filesystem::path description;  ///< the file that this was read from
  std::filesystem::path clip;         ///< a movie, or a sound file
  std::optional<Vector3> speaker_m;   ///< mouth, source view's frame
  std::optional<Box> speaker_box;     ///< in the clip's picture
  std::optional<double> fov_deg;      ///< horizontal, of the clip's camera
  std::optional<MapPicture> map;
  std::vector<KnownEarpoint> earpoints;  ///< at least one
};

/// Reads a description as examples/earpoints.json; docs/formats.md has its fields. Files that it
/// names are relative to its folder.
/// @throws InputError naming the field that is missing, unknown or malformed, or a file that is not
///         there
[[nodiscard]] EarpointClip read_earpoint_clip(const std::filesystem::path& path);

}  // namespace earpoint
