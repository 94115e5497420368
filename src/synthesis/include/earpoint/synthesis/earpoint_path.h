#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <earpoint/pose.h>

namespace earpoint {

/// Beyond any audible distance: units are then most likely mixed up.
inline constexpr double kFarthestPlace_m = 1e4;
/// A hundred turns: along a path an angle may grow beyond one.
inline constexpr double kLargestDegrees = 36000.0;

/// @throws InputError naming `where` if a coordinate is not finite or beyond kFarthestPlace_m
void check_place(const Vector3& place_m, const std::string& where);
/// The same for the pose of a head. Allocates nothing unless it fails or `where` is long.
/// @throws InputError also if the orientation is not finite or has no length
void check_pose(const Pose& pose, const std::string& where);
/// @throws InputError naming `where` if the angle is not finite or beyond kLargestDegrees
void check_angle_deg(double angle_deg, const std::string& where);

/// Where an earpoint is over time, in the source view's frame: standing still, or moving from row
/// to row of a CSV file.
class EarpointPath {
 public:
  struct Row {
    double time_s = 0.0;
    Pose pose;
  };

  /// Stands still.
  explicit EarpointPath(const Pose& source_from_target);

  /// Moves from row to row, as from_csv().
  /// @throws InputError if there is no row, a time does not grow, or a place is beyond what can be
  ///         heard
  explicit EarpointPath(std::vector<Row> rows);

  /// Reads `time_s,x,y,z,yaw_deg,pitch_deg,roll_deg` (that header first; metres; x front, y left,
  /// z up; lines that start with # are skipped). Positions are interpolated linearly, orientations
  /// along the great arc.
  /// @throws InputError naming the line if a cell is missing or no number or beyond what can be
  ///         heard, a time does not grow, or there is no row
  static EarpointPath from_csv(const std::filesystem::path& path);
  /// The same from text; `name` stands for the file in messages.
  static EarpointPath parse_csv(const std::string& text, const std::string& name);

  /// @throws InputError if the path does not cover [0, duration_s]; half a second may be missing at
  ///         the end, where the last row holds
  void check_covers(double duration_s) const;

  /// @return source_from_target at that time; before the first and after the last row, that row
  [[nodiscard]] Pose at(double time_s) const;
  [[nodiscard]] bool is_moving() const { return rows_.size() > 1; }
  /// @return the time of the last row; 0 for what stands still
  [[nodiscard]] double end_s() const { return rows_.back().time_s; }

 private:
  EarpointPath() = default;

  std::string name_;
  std::vector<Row> rows_;
};

/// Reads one target pose or a list of them: an object, or an array of objects, like
/// `{"position_m": [1, -0.5, 0], "yaw_deg": 90, "pitch_deg": 0, "roll_deg": 0}`; angles left out
/// are 0, and `"quaternion_wxyz": [w, x, y, z]` may stand in their place.
/// @throws InputError naming the field
std::vector<Pose> read_poses_json(const std::filesystem::path& path);
/// The same from text; `name` stands for the file in messages.
std::vector<Pose> parse_poses_json(const std::string& text, const std::string& name);

}  // namespace earpoint
