#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/image.h>
#include <earpoint/pose.h>
#include <earpoint/render_files/render.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// A person in a clip's picture.
struct SeenPerson {
  Box box;
  bool speaks = false;  ///< for most of the clip
};

/// A place where it is known what was heard.
struct KnownPlace {
  std::string name;
  Pose source_from_target;
  Waveform sound;  ///< 2 ears, as long as the clip and at its rate
};

/// The floor plan around a clip, as polygons in the source view's frame, metres.
struct ServedPlan {
  using Polygon = std::vector<std::array<double, 2>>;
  std::vector<Polygon> rooms;
  std::vector<Polygon> doors;  ///< openings in the walls between rooms
};

/// A picture from above in which the source view looks up the page.
struct ServedMap {
  std::vector<std::byte> png;
  double camera_x = 0.0;  ///< where the source view stands, pixels from the left and top edge
  double camera_y = 0.0;
  double pixels_per_metre = 1.0;
};

/// Where the speaker is taken to be.
struct ServedSpeaker {
  Vector3 position_m;        ///< of the mouth, source view's frame
  double heading_rad = 0.0;  ///< where they look
  double spread_rad = 0.0;   ///< standard deviation of the azimuth, where they were found
  bool is_told = false;      ///< given, not found
};

/// A clip in memory, ready to be listened to from anywhere.
struct ServedClip {
  std::string name;                    ///< for people
  Waveform sound;                      ///< 2 ears, at the recording's rate
  std::vector<std::byte> picture_png;  ///< of the clip's middle; empty if there is none
  std::shared_ptr<const Image> picture;
  std::optional<Box> speaker_box;
  std::vector<SeenPerson> people;
  double horizontal_fov_rad = 0.0;
  std::optional<ServedSpeaker> speaker;  ///< nothing: nobody was found
  std::optional<Vector3> speaker_m;      ///< as the user or the data set told it
  std::vector<std::string> warnings;     ///< one line each, for people
  std::vector<KnownPlace> places;
  std::optional<ServedPlan> plan;
  std::optional<ServedMap> map;
  /// The files that it comes from; nothing where it was made in memory.
  std::optional<RenderInput> source;
};

/// Longer recordings are refused: a clip is held in memory.
inline constexpr double kLongestServed_s = 1200.0;

/// Reads a clip, and finds the speaker where nothing tells who it is.
/// @param finder  a network that finds speakers; null: nobody is looked for
/// @throws InputError for a bad recording or picture, or one longer than that
[[nodiscard]] ServedClip open_served_clip(const RenderInput& source, const GtfWeights* finder,
                                          double horizontal_fov_rad, ProgressSink& progress);

}  // namespace earpoint
