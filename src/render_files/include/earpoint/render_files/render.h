#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/plot/plot.h>
#include <earpoint/pose.h>
#include <earpoint/render/clip_options.h>
#include <earpoint/render_files/sound_input.h>
#include <earpoint/synthesis/earpoint_path.h>
#include <earpoint/synthesis/speaker_track.h>
#include <earpoint/synthesis/synthesizer.h>

namespace earpoint {

/// What is rendered: the sound, and the picture that goes with it.
struct RenderInput {
  SoundInput sound;
  /// A still picture, or a movie. Without it the picture is the sound's own movie, if it is one.
  std::optional<std::filesystem::path> picture;
  /// The speaker's box in the picture, or position in the source view's frame.
  std::optional<SpeakerTrack> speaker_track;
  std::optional<Vector3> speaker_m;
  /// survey_sound() of this sound; read again where it is not given.
  std::optional<SoundSurvey> survey{};
};

/// One earpoint and where its sound goes: .wav, .flac, .ogg or .w64, or .mp4 with the picture.
struct RenderTarget {
  EarpointPath path;
  std::filesystem::path output;
};

struct RenderReport {
  SoundSurvey survey;
  WaveformOutline source;                ///< what was recorded
  std::vector<WaveformOutline> targets;  ///< what was written
  /// By how much every target's peaks exceeded full scale before they were limited, in decibels; 0
  /// where they did not, or nothing limits them.
  std::vector<double> limited_db;
  int windows = 0;
  int model_rate_hz = 0;  ///< at which the synthesizer worked
  bool has_picture = false;
  /// What of it the synthesizer was not made for; AcousticSynthesizer::warnings().
  std::vector<std::string> warnings;
};

/// Renders a whole clip for every target in one pass over the recording: windows, cross-fades,
/// ambient sound and the band above the model's. Outputs appear only when all are whole.
///
/// Memory is bounded by a few windows, whatever the clip's length.
/// @throws InputError for a bad recording, picture, path or output, with nothing written
RenderReport render(const RenderInput& source, AcousticSynthesizer& synthesizer,
                    std::span<const RenderTarget> targets, const ClipRenderOptions& options,
                    ProgressSink& progress);

}  // namespace earpoint
