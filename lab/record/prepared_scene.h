#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/pose.h>
#include <earpoint/vector3.h>

namespace earpoint {

/// Where the published data set has its clips, below the data set's folder.
[[nodiscard]] std::filesystem::path prepared_folder(const std::filesystem::path& out);

/// A clip as its folder tells: clip.json.
struct PreparedClip {
  int window = 0;  ///< the folder's name
  double time_s = 0.0;
  std::string speaker;
  bool overlapping = false;
  std::optional<Vector3> mouth_m;
  std::vector<std::string> images;
};

[[nodiscard]] std::string json_of(const PreparedClip& clip);
/// @return nothing if the clip is not there, or lacks a file
[[nodiscard]] std::optional<PreparedClip> stored_clip(const std::filesystem::path& folder);

/// A camera as the authors' camera file has it.
struct PreparedCamera {
  int number = 0;
  Pose world_from_camera;
  std::optional<double> horizontal_fov_rad;  ///< nothing where the lens is not known
};

/// Writes scene.json: what the files of the whole data set need to know of a scene.
void write_scene(const std::filesystem::path& folder, const std::string& split,
                 const std::vector<PreparedCamera>& cameras,
                 const std::vector<PreparedClip>& clips);

/// Puts metadata, splits, clips and camera positions of all scenes together.
/// @throws InputError if a scene's record is malformed
void write_dataset_files(const std::filesystem::path& out);

}  // namespace earpoint
