#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <earpoint/core/image.h>
#include <earpoint/core/pose.h>
#include <earpoint/core/progress.h>
#include <earpoint/plot/plot.h>
#include <earpoint/render/source_stream.h>
#include <earpoint/synthesis/earpoint_path.h>
#include <earpoint/synthesis/speaker_track.h>
#include <earpoint/synthesis/synthesizer.h>

namespace earpoint {

/// What is rendered: the sound, and the picture that goes with it.
struct RenderSource {
  SoundSource sound;
  /// A still picture, or a movie. Without it the picture is the sound's own movie, if it is one.
  std::optional<std::filesystem::path> picture;
  /// The speaker's box in the picture, or position in the source view's frame.
  std::optional<SpeakerTrack> speaker_track;
  std::optional<Vector3> speaker_m;
};

/// One earpoint and where its sound goes: .wav, .flac, .ogg or .w64, or .mp4 with the picture.
struct RenderTarget {
  EarpointPath path;
  std::filesystem::path output;
};

/// What a synthesizer's answer is.
enum class RenderAnswer {
  place,  ///< what both ears hear at the target; ambient sound is added
  /// The speaker's voice, of a network that was trained for enhancement: without ambient sound, the
  /// mean of both channels; sound files have one channel.
  voice,
};

struct ClipRenderOptions {
  RenderAnswer answer = RenderAnswer::place;
  /// Carry the band above the model's Nyquist frequency along (BandExtension). Without it the
  /// output has the model's band only, at the recording's rate.
  bool extend_band = true;
  AmbientSeparation ambient = AmbientSeparation::bandpass;
  /// Instead of the synthesizer's own.
  std::optional<double> ambient_cutoff_hz;
  double gain_db = 0.0;
  /// Keep the output within full scale (PeakLimiter).
  bool limit = true;
  /// With two or more, other windows are read and written while one is synthesized.
  int threads = 1;
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

/// A sound in memory, and what is known of the moment.
struct SoundInMemory {
  Waveform sound;                        ///< 2 ears, at the synthesizer's rate or above
  std::shared_ptr<const Image> picture;  ///< a still one; null: none
  std::optional<Box> speaker_box;        ///< nothing: out of sight, or not known
  std::optional<Vector3> speaker_m;
  std::optional<Pose> world_from_source;  ///< as Observation has it
};

/// Renders a sound in memory as render() does a file: the same windows and cross-fades, the same
/// ambient sound, the same band above the model's.
/// @return 2 ears, as long as the sound and at its rate
/// @throws InputError if something that the synthesizer needs is missing
[[nodiscard]] Waveform render_in_memory(const SoundInMemory& source,
                                        AcousticSynthesizer& synthesizer, const EarpointPath& path,
                                        const ClipRenderOptions& options);

/// Renders a whole clip for every target in one pass over the recording: windows, cross-fades,
/// ambient sound and the band above the model's. Outputs appear only when all are whole.
///
/// Memory is bounded by a few windows, whatever the clip's length.
/// @throws InputError for a bad recording, picture, path or output, with nothing written
RenderReport render(const RenderSource& source, AcousticSynthesizer& synthesizer,
                    std::span<const RenderTarget> targets, const ClipRenderOptions& options,
                    ProgressSink& progress);

}  // namespace earpoint
