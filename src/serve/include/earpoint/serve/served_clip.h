#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/core/image.h>
#include <earpoint/core/progress.h>
#include <earpoint/core/waveform.h>
#include <earpoint/model/gtf.h>
#include <earpoint/synth/locate_speaker.h>
#include <earpoint/synth/render.h>

namespace earpoint {

/// A clip in memory, ready to be listened to from anywhere.
struct ServedClip {
  std::string name;                    ///< of the file
  Waveform sound;                      ///< 2 ears, at the recording's rate
  std::vector<std::byte> picture_png;  ///< of the clip's middle; empty if there is none
  std::shared_ptr<const Image> picture;
  std::optional<Box> speaker_box;
  double horizontal_fov_rad = 0.0;
  LocatedSpeaker located;             ///< where the network takes the speaker to be
  std::optional<Vector3> speaker_m;   ///< as the user told it
  std::vector<std::string> warnings;  ///< one line each, for people
  GtfWeights weights;
};

/// Longer recordings are refused: a clip is held in memory.
inline constexpr double kLongestServed_s = 1200.0;

/// Reads a clip and finds the speaker.
/// @throws InputError for a bad recording or picture, one longer than that, or a weight file that
/// is
///         no gtf
[[nodiscard]] ServedClip open_served_clip(const RenderSource& source,
                                          const std::filesystem::path& gtf_file,
                                          double horizontal_fov_rad, ProgressSink& progress);

}  // namespace earpoint
