#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <earpoint/core/error.h>
#include <earpoint/core/file.h>
#include <earpoint/core/parallel.h>
#include <earpoint/synth/picture_stream.h>
#include <earpoint/synth/render.h>
#include <earpoint/synth/sound_sink.h>
#include <earpoint/synth/target_stream.h>
#include <earpoint/video/media.h>

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
    throw InputError(source.sound.path.string(),
                     "this model looks at the scene, and here is no picture",
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

std::vector<TargetStream> open_targets(std::span<const RenderTarget> targets,
                                       const SoundSurvey& survey, const WindowShape& shape,
                                       const ClipRenderOptions& options,
                                       const std::filesystem::path& movie) {
  std::vector<TargetStream> streams;
  for (const RenderTarget& target : targets) {
    streams.emplace_back(
        open_sound_sink(target.output, survey.sample_rate_hz, movie, survey.samples), survey, shape,
        options);
  }
  return streams;
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

Observation observation_of(const RenderSource& source, const Moment& moment) {
  Observation observation;
  observation.sound = moment.sound.primary;
  observation.picture = moment.picture;
  if (source.speaker_track) observation.speaker_box = source.speaker_track->at(moment.middle_s);
  observation.speaker_m = source.speaker_m;
  return observation;
}

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

/// One pass over the recording: every window goes from the source through the synthesizer to the
/// targets. While one is synthesized, that before it is written and that behind it read.
class Rendering {
 public:
  Rendering(const RenderSource& source, AcousticSynthesizer& synthesizer,
            std::span<const RenderTarget> targets, const ClipRenderOptions& options)
      : source_(source),
        synthesizer_(synthesizer),
        targets_(targets),
        survey_(survey_sound(source.sound)),
        shape_(synthesizer.window_shape(survey_.sample_rate_hz)),
        pool_(std::min(2, options.threads)) {
    for (const RenderTarget& target : targets) target.path.check_covers(survey_.duration_s());
    const std::filesystem::path movie = moving_picture(source);
    pictures_ = pictures_for(source, synthesizer);
    stream_.emplace(source.sound, survey_, shape_.sample_rate_hz,
                    options.ambient_cutoff_hz.value_or(synthesizer.ambient_cutoff_hz()));
    outputs_ = open_targets(targets, survey_, shape_, options, movie);
  }

  RenderReport run(ProgressSink& progress) {
    const std::ptrdiff_t windows = count_windows(stream_->model_samples(), shape_);
    bool has_picture = false;
    progress.begin("rendering", survey_.duration_s(), "s");
    Moment next = read(0);
    Moment previous;
    std::vector<Waveform> previous_results;
    for (std::ptrdiff_t index = 0; index < windows; ++index) {
      Moment moment = std::exchange(next, {});
      has_picture |= moment.picture != nullptr;
      std::vector<Waveform> results;
      pool_.run(2, [&](std::ptrdiff_t task, int /*worker*/) {
        if (task == 1) {
          results = synthesize_all(moment, start_of(index));
          return;
        }
        if (index > 0) write(previous, previous_results);
        if (index + 1 < windows) next = read(index + 1);
      });
      previous = std::move(moment);
      previous_results = std::move(results);
      // The last window takes its overlap along.
      const std::ptrdiff_t done =
          index + 1 < windows ? start_of(1) : stream_->model_samples() - start_of(index);
      progress.advance(static_cast<double>(done) / shape_.sample_rate_hz);
    }
    write(previous, previous_results);
    for (TargetStream& output : outputs_) output.finish(*stream_);
    RenderReport report{.survey = survey_,
                        .source = stream_->outline(),
                        .targets = {},
                        .limited_db = {},
                        .windows = static_cast<int>(windows),
                        .doubts = {}};
    report.doubts = synthesizer_.doubts(outline_of(source_, survey_, targets_, has_picture));
    for (TargetStream& output : outputs_) {
      output.commit();
      report.targets.push_back(output.outline());
      report.limited_db.push_back(output.limited_db());
    }
    progress.finish();
    return report;
  }

 private:
  [[nodiscard]] std::ptrdiff_t start_of(std::ptrdiff_t index) const {
    return index * (shape_.samples - shape_.overlap);
  }

  Moment read(std::ptrdiff_t index) {
    Moment moment;
    moment.middle_s =
        (static_cast<double>(start_of(index)) + static_cast<double>(shape_.samples) / 2) /
        shape_.sample_rate_hz;
    moment.sound = stream_->window(start_of(index), shape_.samples, shape_.context);
    moment.picture = pictures_.nearest(moment.middle_s);
    return moment;
  }

  std::vector<Waveform> synthesize_all(const Moment& moment, std::ptrdiff_t start) {
    synthesizer_.observe(observation_of(source_, moment));
    std::vector<Waveform> results;
    for (const RenderTarget& target : targets_) {
      results.push_back(synthesize(synthesizer_, target.path, shape_, start));
    }
    return results;
  }

  void write(const Moment& moment, std::span<const Waveform> results) {
    const Waveform primary = without_context(moment.sound.primary, shape_);
    std::ptrdiff_t needed = survey_.samples;
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      outputs_[i].add_window(primary, results[i], moment.sound.ambient, *stream_);
      needed = std::min(needed, outputs_[i].written());
    }
    stream_->drop_high_band_before(needed);
  }

  const RenderSource& source_;
  AcousticSynthesizer& synthesizer_;
  std::span<const RenderTarget> targets_;
  SoundSurvey survey_;
  WindowShape shape_;
  ThreadPool pool_;
  PictureStream pictures_;
  std::optional<SourceStream> stream_;
  std::vector<TargetStream> outputs_;
};

}  // namespace

RenderReport render(const RenderSource& source, AcousticSynthesizer& synthesizer,
                    std::span<const RenderTarget> targets, const ClipRenderOptions& options,
                    ProgressSink& progress) {
  EARPOINT_CHECK(!targets.empty());
  check_outputs(targets, source);
  return Rendering(source, synthesizer, targets, options).run(progress);
}

}  // namespace earpoint
