#include <earpoint/render/render.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <earpoint/core/error.h>
#include <earpoint/core/file.h>
#include <earpoint/core/parallel.h>
#include <earpoint/media/media.h>
#include <earpoint/render/picture_stream.h>
#include <earpoint/render/sound_sink.h>
#include <earpoint/render/target_stream.h>

namespace earpoint {
namespace {

/// The movie whose picture goes with the sound; empty if there is none.
std::filesystem::path moving_picture(const RenderSource& source) {
  const std::filesystem::path path = source.picture.value_or(source.sound.path);
  return probe_media(path).kind == MediaKind::movie ? path : std::filesystem::path();
}

PictureStream pictures_for(const RenderSource& source, const AcousticSynthesizer& synthesizer) {
  const PictureUse use = synthesizer.picture_use();
  const bool by_box = source.speaker_track && !source.speaker_m;
  if (use == PictureUse::never || (use == PictureUse::with_box && !by_box)) return {};
  PictureStream pictures = open_pictures(source.picture, source.sound.path);
  if (use == PictureUse::always && pictures.empty()) {
    throw InputError(source.sound.path.string(), "this model needs a picture, and there is none",
                     "give a picture before the sound: earpoint render frame.png sound.flac");
  }
  return pictures;
}

RenderOutline outline_of(const RenderSource& source, const SoundSurvey& survey,
                         std::span<const RenderTarget> targets, bool has_picture) {
  RenderOutline outline{.duration_s = survey.duration_s(),
                        .level_db = std::max(survey.level_db[0], survey.level_db[1]),
                        .has_picture = has_picture,
                        .speaker_track = source.speaker_track,
                        .speaker_m = source.speaker_m,
                        .targets = {}};
  for (const RenderTarget& target : targets) outline.targets.push_back(target.path);
  return outline;
}

std::ptrdiff_t count_windows(std::ptrdiff_t samples, const WindowShape& shape) {
  const std::ptrdiff_t hop = shape.samples - shape.overlap;
  // The joined windows must reach the end; a tail that the last overlap covers needs no window.
  return std::max<std::ptrdiff_t>(1, (samples - shape.overlap + hop - 1) / hop);
}

Waveform without_context(const Waveform& sound, const WindowShape& shape) {
  Waveform middle(sound.channels(), shape.samples, sound.sample_rate_hz());
  for (int c = 0; c < sound.channels(); ++c) {
    std::copy_n(sound.channel(c).begin() + shape.context, shape.samples, middle.channel(c).begin());
  }
  return middle;
}

std::vector<std::unique_ptr<SoundSink>> open_sinks(std::span<const RenderTarget> targets,
                                                   const RenderSource& source,
                                                   const SoundSurvey& survey, RenderAnswer answer) {
  const int channels = answer == RenderAnswer::voice ? 1 : 2;
  const std::filesystem::path movie = moving_picture(source);
  std::vector<std::unique_ptr<SoundSink>> sinks;
  for (const RenderTarget& target : targets) {
    sinks.push_back(
        open_sound_sink(target.output, survey.sample_rate_hz, movie, survey.samples, channels));
  }
  return sinks;
}

/// What the synthesizer makes of the window that it observed last, which starts at sample `start`.
Waveform synthesize(AcousticSynthesizer& synthesizer, const EarpointPath& path,
                    const WindowShape& shape, std::ptrdiff_t start) {
  const auto pose_at = [&](std::ptrdiff_t sample) {
    return path.at(static_cast<double>(start + sample) / shape.sample_rate_hz);
  };
  if (!path.is_moving() || shape.pose_step == 0) {
    return synthesizer.synthesize(pose_at(shape.samples / 2));
  }
  std::vector<Pose> poses;
  for (std::ptrdiff_t sample = 0; sample <= shape.samples; sample += shape.pose_step) {
    poses.push_back(pose_at(sample));
  }
  return synthesizer.synthesize_along(poses);
}

/// What is read of a window before anything is made of it.
struct Moment {
  SourceStream::Window sound;
  std::shared_ptr<const Image> picture;
  double middle_s = 0.0;
};

void check_outputs(std::span<const RenderTarget> targets, const RenderSource& source) {
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const std::filesystem::path& output = targets[i].output;
    for (std::size_t j = 0; j < i; ++j) {
      if (written_place(output) == written_place(targets[j].output)) {
        throw InputError(output.string(), "two earpoints would write this file",
                         "give each its own");
      }
    }
    std::error_code ignored;
    if (std::filesystem::equivalent(output, source.sound.path, ignored)) {
      throw InputError(output.string(), "is the recording itself", "write to another file");
    }
  }
}

/// What is rendered, ready to be read once.
struct Reading {
  SoundSurvey survey;
  BlockReader sound;
  PictureStream pictures;
  /// Where the speaker is seen at a time, if that is known.
  std::function<std::optional<Box>(double time_s)> speaker_box;
  std::optional<Vector3> speaker_m;
  std::optional<Pose> world_from_source;
};

/// One pass over the recording: every window goes from the source through the synthesizer to the
/// targets. While one is synthesized, that before it is written and that behind it read.
class Rendering {
 public:
  Rendering(Reading reading, AcousticSynthesizer& synthesizer,
            std::span<const EarpointPath> targets, const ClipRenderOptions& options)
      : reading_(std::move(reading)),
        synthesizer_(synthesizer),
        targets_(targets),
        shape_(synthesizer.window_shape(reading_.survey.sample_rate_hz)),
        pool_(std::min(2, options.threads)),
        stream_(reading_.sound, reading_.survey, shape_.sample_rate_hz,
                {options.ambient,
                 options.ambient_cutoff_hz.value_or(synthesizer.ambient_cutoff_hz())}) {
    for (const EarpointPath& path : targets) path.check_covers(reading_.survey.duration_s());
  }

  /// Writes target by target into the sinks, and commits none.
  std::vector<TargetStream> run(std::vector<std::unique_ptr<SoundSink>> sinks,
                                const ClipRenderOptions& options, ProgressSink& progress) {
    for (std::unique_ptr<SoundSink>& sink : sinks) {
      outputs_.emplace_back(std::move(sink), reading_.survey, shape_, options);
    }
    progress.begin("rendering", reading_.survey.duration_s(), "s");
    Moment next = read(0);
    Moment previous;
    std::vector<Waveform> previous_results;
    for (std::ptrdiff_t index = 0; index < windows(); ++index) {
      Moment moment = std::exchange(next, {});
      has_picture_ |= moment.picture != nullptr;
      std::vector<Waveform> results;
      pool_.run(2, [&](std::ptrdiff_t task, int /*worker*/) {
        if (task == 1) {
          results = synthesize_all(moment, start_of(index));
          return;
        }
        if (index > 0) write(previous, previous_results);
        if (index + 1 < windows()) next = read(index + 1);
      });
      previous = std::move(moment);
      previous_results = std::move(results);
      // The last window takes its overlap along.
      const std::ptrdiff_t done =
          index + 1 < windows() ? start_of(1) : stream_.model_samples() - start_of(index);
      progress.advance(static_cast<double>(done) / shape_.sample_rate_hz);
    }
    write(previous, previous_results);
    for (TargetStream& output : outputs_) output.finish(stream_);
    return std::move(outputs_);
  }

  [[nodiscard]] std::ptrdiff_t windows() const {
    return count_windows(stream_.model_samples(), shape_);
  }
  [[nodiscard]] bool has_picture() const { return has_picture_; }
  [[nodiscard]] int model_rate_hz() const { return shape_.sample_rate_hz; }
  [[nodiscard]] const SoundSurvey& survey() const { return reading_.survey; }
  [[nodiscard]] const WaveformOutline& source_outline() const { return stream_.outline(); }

 private:
  [[nodiscard]] std::ptrdiff_t start_of(std::ptrdiff_t index) const {
    return index * (shape_.samples - shape_.overlap);
  }

  Moment read(std::ptrdiff_t index) {
    Moment moment;
    moment.middle_s =
        (static_cast<double>(start_of(index)) + static_cast<double>(shape_.samples) / 2) /
        shape_.sample_rate_hz;
    moment.sound = stream_.window(start_of(index), shape_.samples, shape_.context);
    moment.picture = reading_.pictures.nearest(moment.middle_s);
    return moment;
  }

  std::vector<Waveform> synthesize_all(const Moment& moment, std::ptrdiff_t start) {
    synthesizer_.observe({.sound = moment.sound.primary,
                          .picture = moment.picture,
                          .speaker_box = reading_.speaker_box(moment.middle_s),
                          .speaker_m = reading_.speaker_m,
                          .world_from_source = reading_.world_from_source});
    std::vector<Waveform> results;
    for (const EarpointPath& path : targets_) {
      results.push_back(synthesize(synthesizer_, path, shape_, start));
    }
    return results;
  }

  void write(const Moment& moment, std::span<const Waveform> results) {
    const Waveform primary = without_context(moment.sound.primary, shape_);
    std::ptrdiff_t needed = reading_.survey.samples;
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      outputs_[i].add_window(primary, results[i], moment.sound.ambient, stream_);
      needed = std::min(needed, outputs_[i].written());
    }
    stream_.drop_high_band_before(needed);
  }

  Reading reading_;
  AcousticSynthesizer& synthesizer_;
  std::span<const EarpointPath> targets_;
  WindowShape shape_;
  ThreadPool pool_;
  SourceStream stream_;
  std::vector<TargetStream> outputs_;
  bool has_picture_ = false;
};

Reading reading_of(const RenderSource& source, const AcousticSynthesizer& synthesizer) {
  if (synthesizer.needs_speaker_track() && !source.speaker_track) {
    throw InputError(source.sound.path.string(), "the network must be told who speaks in it",
                     "give the speaker's box or a table of boxes");
  }
  Reading reading{.survey = survey_sound(source.sound),
                  .sound = read_blocks(source.sound),
                  .pictures = pictures_for(source, synthesizer),
                  .speaker_box = {},
                  .speaker_m = source.speaker_m,
                  .world_from_source = std::nullopt};
  reading.speaker_box = [track = source.speaker_track](double time_s) {
    return track ? std::optional<Box>(track->at(time_s)) : std::nullopt;
  };
  return reading;
}

/// Keeps what is written.
class MemorySink : public SoundSink {
 public:
  explicit MemorySink(Waveform& sound) : sound_(sound) {}
  void write(const Waveform& block) override {
    EARPOINT_CHECK(written_ + block.samples() <= sound_.samples());
    for (int c = 0; c < block.channels(); ++c) {
      std::ranges::copy(block.channel(c), sound_.channel(c).begin() + written_);
    }
    written_ += block.samples();
  }
  void commit() override {}
  [[nodiscard]] int sample_rate_hz() const override { return sound_.sample_rate_hz(); }

 private:
  Waveform& sound_;
  std::ptrdiff_t written_ = 0;
};

/// The sound from its beginning, in blocks.
BlockReader read_blocks(const Waveform& sound) {
  return [&sound, read = std::ptrdiff_t{0}](std::ptrdiff_t samples) mutable {
    const std::ptrdiff_t count = std::min(samples, sound.samples() - read);
    Waveform block(sound.channels(), count, sound.sample_rate_hz());
    for (int c = 0; c < sound.channels(); ++c) {
      std::ranges::copy(sound.channel(c).subspan(read, count), block.channel(c).begin());
    }
    read += count;
    return block;
  };
}

}  // namespace

Waveform render_in_memory(const SoundInMemory& source, AcousticSynthesizer& synthesizer,
                          const EarpointPath& path, const ClipRenderOptions& options) {
  EARPOINT_CHECK(source.sound.channels() == 2 && !source.sound.empty());
  Reading reading;
  reading.survey.sample_rate_hz = source.sound.sample_rate_hz();
  reading.survey.samples = source.sound.samples();
  reading.sound = read_blocks(source.sound);
  reading.pictures = PictureStream(source.picture);
  reading.speaker_box = [&source](double /*time_s*/) { return source.speaker_box; };
  reading.speaker_m = source.speaker_m;
  reading.world_from_source = source.world_from_source;
  Waveform result(2, source.sound.samples(), source.sound.sample_rate_hz());
  std::vector<std::unique_ptr<SoundSink>> sinks;
  sinks.push_back(std::make_unique<MemorySink>(result));
  SilentProgress silent;
  (void)Rendering(std::move(reading), synthesizer, {&path, 1}, options)
      .run(std::move(sinks), options, silent);
  return result;
}

RenderReport render(const RenderSource& source, AcousticSynthesizer& synthesizer,
                    std::span<const RenderTarget> targets, const ClipRenderOptions& options,
                    ProgressSink& progress) {
  EARPOINT_CHECK(!targets.empty());
  check_outputs(targets, source);
  std::vector<EarpointPath> paths;
  for (const RenderTarget& target : targets) paths.push_back(target.path);
  Rendering rendering(reading_of(source, synthesizer), synthesizer, paths, options);
  std::vector<TargetStream> outputs = rendering.run(
      open_sinks(targets, source, rendering.survey(), options.answer), options, progress);
  RenderReport report{.survey = rendering.survey(),
                      .source = rendering.source_outline(),
                      .targets = {},
                      .limited_db = {},
                      .windows = static_cast<int>(rendering.windows()),
                      .model_rate_hz = rendering.model_rate_hz(),
                      .has_picture = rendering.has_picture(),
                      .warnings = {}};
  report.warnings =
      synthesizer.warnings(outline_of(source, report.survey, targets, rendering.has_picture()));
  for (TargetStream& output : outputs) {
    output.commit();
    report.targets.push_back(output.outline());
    report.limited_db.push_back(output.limited_db());
  }
  progress.finish();
  return report;
}

}  // namespace earpoint
