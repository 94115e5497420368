#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/pose.h>
#include <earpoint/vector3.h>

namespace earpoint {

/// How a camera maps directions to pixels: OpenCV's pinhole camera with lens distortion.
struct Lens {
  int width_px = 0;
  int height_px = 0;
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;
  double cy_px = 0.0;
  /// k1, k2, p1, p2 [, k3 [, k4, k5, k6]], as OpenCV orders them; empty: none.
  std::vector<double> distortion;

  friend bool operator==(const Lens&, const Lens&) = default;
};

/// A camera with two microphones, which are the ears of a head that looks where the camera looks.
struct SessionCamera {
  std::string name;             ///< unique in the session; "1" to "8" in prepared data
  std::filesystem::path video;  ///< a movie with binaural sound
  std::optional<Lens> lens;
  /// Where it stands in the room: metres, z up, its x axis where it looks; nothing where it was not
  /// calibrated.
  std::optional<Pose> world_from_camera;
};

/// From the mouth to the microphone that someone wears, where the session does not say it.
inline constexpr double kNearDistance_m = 0.2;

/// Someone who wears a microphone.
struct SessionPerson {
  std::string name;            ///< unique in the session
  std::filesystem::path near;  ///< what the microphone recorded; its first channel counts
  double near_distance_m = kNearDistance_m;  ///< of that microphone from the mouth
};

/// One recording with several cameras: docs/formats.md, "Recorded sessions".
struct Session {
  std::filesystem::path file;  ///< that it was read from, for messages
  std::string scene;           ///< e.g. "SC-1027"; the name of its folder where the file tells none
  std::optional<std::string> split;  ///< train, val or test, where the file tells it
  std::vector<SessionCamera> cameras;
  std::vector<SessionPerson> people;
  /// Whether it is known who wears which microphone; else each person has any of them, and boxes
  /// tell whose it is.
  bool wearers_known = true;
  /// When about the clapper is heard on the first camera's clock, and where it is, if known.
  std::optional<double> clap_s;
  std::optional<Vector3> clap_m;
  /// Where people are seen: a table as of read_person_boxes() in session_truth.h, if there is one.
  std::optional<std::filesystem::path> boxes;
};

/// Reads session.json and the calibration files that it names. Paths of media are made relative to
/// its folder; whether the media are there is for check_session() to find out.
/// @throws InputError naming the field that is missing, malformed or not known
[[nodiscard]] Session read_session(const std::filesystem::path& path);

/// Writes session.json in the frame "earpoint" and metres. Paths of media are written relative to
/// its folder where they lie below it.
/// @throws InputError if it cannot be written
void write_session(const std::filesystem::path& path, const Session& session);

}  // namespace earpoint
