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
/// While a group of windows is rendered, the group before it is written and the one behind it read.
/// Memory is bounded by a few windows for each thread.
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
  struct Window {
    SourceStream::Window sound;
    std::shared_ptr<const Image> picture;  ///< until it is rendered
    std::optional<Box> speaker_box;
    double middle_s = 0.0;
    std::ptrdiff_t start = 0;
    std::vector<Waveform> results;  ///< of every target, once it is rendered
  };

  [[nodiscard]] std::ptrdiff_t start_of(std::ptrdiff_t index) const;
  [[nodiscard]] Window read(std::ptrdiff_t index);
  /// Those of a group, fewer at the end of the clip.
  [[nodiscard]] std::vector<Window> read_group(std::ptrdiff_t first);
  void render(Window& window, AcousticSynthesizer& synthesizer) const;
  void write(const Window& window);

  ClipReading reading_;
  std::span<const EarpointPath> targets_;
  WindowShape shape_;
  SourceStream stream_;
  std::vector<std::unique_ptr<AcousticSynthesizer>> twins_;
  std::vector<AcousticSynthesizer*> synthesizers_;  ///< one, or one for each thread
  std::ptrdiff_t group_;  ///< windows that are rendered before threads wait for each other
  ThreadPool pool_;
  std::vector<TargetStream> outputs_;
  bool has_picture_ = false;
};

}  // namespace earpoint
