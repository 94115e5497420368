#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <earpoint/audio/ambient_separation.h>
#include <earpoint/core/parallel.h>
#include <earpoint/core/progress.h>
#include <earpoint/image.h>
#include <earpoint/plot/plot.h>
#include <earpoint/pose.h>
#include <earpoint/render/clip_options.h>
#include <earpoint/render/sound_sink.h>
#include <earpoint/render/source_stream.h>
#include <earpoint/render/target_stream.h>
#include <earpoint/synthesis/earpoint_path.h>
#include <earpoint/synthesis/synthesizer.h>

namespace earpoint {

/// A clip that is ready to be read once, wherever its sound and pictures come from.
struct ClipReading {
  SoundSurvey survey;
  BlockReader sound;
  /// The frame nearest to a time, null where there is none; an empty function: no pictures.
  std::function<std::shared_ptr<const Image>(double time_s)> picture;
  /// Where the speaker is seen at a time, if that is known; an empty function: it is not.
  std::function<std::optional<Box>(double time_s)> speaker_box;
  std::optional<Vector3> speaker_m;
  std::optional<Pose> world_from_source;
};

/// One pass over a clip: every window goes from the source through the synthesizer to the targets.
/// While one is synthesized, that before it is written and that behind it read. Memory is bounded
/// by a few windows.
class ClipRendering {
 public:
  /// @param synthesizer, targets  must outlive it
  /// @throws InputError if a path does not cover the clip
  ClipRendering(ClipReading reading, AcousticSynthesizer& synthesizer,
                std::span<const EarpointPath> targets, const ClipRenderOptions& options);

  /// Writes target by target into the sinks, and commits none.
  [[nodiscard]] std::vector<TargetStream> run(std::vector<std::unique_ptr<SoundSink>> sinks,
                                              const ClipRenderOptions& options,
                                              ProgressSink& progress);

  [[nodiscard]] std::ptrdiff_t windows() const;
  /// After run(): whether any window had a picture.
  [[nodiscard]] bool has_picture() const { return has_picture_; }
  [[nodiscard]] int model_rate_hz() const { return shape_.sample_rate_hz; }
  [[nodiscard]] const SoundSurvey& survey() const { return reading_.survey; }
  [[nodiscard]] const WaveformOutline& source_outline() const { return stream_.outline(); }

 private:
  /// What is read of a window before anything is made of it.
  struct Moment {
    SourceStream::Window sound;
    std::shared_ptr<const Image> picture;
    double middle_s = 0.0;
  };

  [[nodiscard]] std::ptrdiff_t start_of(std::ptrdiff_t index) const;
  Moment read(std::ptrdiff_t index);
  std::vector<Waveform> synthesize_all(const Moment& moment, std::ptrdiff_t start);
  void write(const Moment& moment, std::span<const Waveform> results);

  ClipReading reading_;
  AcousticSynthesizer& synthesizer_;
  std::span<const EarpointPath> targets_;
  WindowShape shape_;
  ThreadPool pool_;
  SourceStream stream_;
  std::vector<TargetStream> outputs_;
  bool has_picture_ = false;
};

}  // namespace earpoint
