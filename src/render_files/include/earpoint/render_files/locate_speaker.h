#pragma once

#include <optional>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/gtf/engine.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/image.h>
#include <earpoint/render/source_stream.h>
#include <earpoint/render_files/render.h>

namespace earpoint {

/// Where the speaker was found during one window of a recording.
struct SpeakerSighting {
  double time_s = 0.0;  ///< the window's middle
  GtfSpeaker speaker;
  double level = 0.0;  ///< root mean square of both ears
};

/// Where the speaker of a recording is.
struct LocatedSpeaker {
  GtfSpeaker speaker;  ///< the mean over windows, the loud ones first
  /// Standard deviations over windows: of the azimuth, and of the distance's logarithm. They tell
  /// how steady the answer is, not how right; 0 with a single window. Of stereo that is not
  /// binaural they are those of any distance and, without a box, any azimuth; the heading's
  /// certainty is 0.
  double azimuth_spread_rad = 0.0;
  double log_distance_spread = 0.0;
  bool has_picture = false;  ///< the network looked at one
  bool has_box = false;      ///< it was told where the speaker is seen
  SoundSurvey survey;        ///< of the recording, with warnings
  std::vector<SpeakerSighting> sightings;
};

/// Finds the speaker of a recording, window by window, by picture, box and sound.
/// @param weights             of a network with geometry: others find no speaker
/// @param horizontal_fov_rad  of the source camera
/// @throws InputError for a bad recording or picture
[[nodiscard]] LocatedSpeaker locate_speaker(const RenderInput& source, const GtfWeights& weights,
                                            double horizontal_fov_rad, ProgressSink& progress);

/// The mean over sightings, weighted by power. At least one must be no silence.
[[nodiscard]] LocatedSpeaker mean_speaker(std::vector<SpeakerSighting> sightings);

/// The speaker from above: the source camera below, looking up the page with its field of view,
/// rings of a metre, a dot for each window, the mean with the way that they face.
[[nodiscard]] Image plot_speaker(const LocatedSpeaker& located, double horizontal_fov_rad);

}  // namespace earpoint
