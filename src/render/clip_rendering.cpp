#include <earpoint/render/clip_rendering.h>

#include <algorithm>
#include <utility>

#include <earpoint/audio/window_of.h>

namespace earpoint {
namespace {

std::ptrdiff_t count_windows(std::ptrdiff_t samples, const WindowShape& shape) {
  const std::ptrdiff_t hop = shape.samples - shape.overlap;
  // The joined windows must reach the end; a tail that the last overlap covers needs no window.
  return std::max<std::ptrdiff_t>(1, (samples - shape.overlap + hop - 1) / hop);
}

Waveform without_context(const Waveform& sound, const WindowShape& shape) {
  return window_of(sound, shape.context, shape.samples);
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

}  // namespace

ClipRendering::ClipRendering(ClipReading reading, AcousticSynthesizer& synthesizer,
                             std::span<const EarpointPath> targets,
                             const ClipRenderOptions& options)
    : reading_(std::move(reading)),
      synthesizer_(synthesizer),
      targets_(targets),
      shape_(synthesizer.window_shape(reading_.survey.sample_rate_hz)),
      pool_(std::min(2, options.threads)),
      stream_(
          reading_.sound, reading_.survey, shape_.sample_rate_hz,
          {options.ambient, options.ambient_cutoff_hz.value_or(synthesizer.ambient_cutoff_hz())}) {
  for (const EarpointPath& path : targets) path.check_covers(reading_.survey.duration_s());
}

std::vector<TargetStream> ClipRendering::run(std::vector<std::unique_ptr<SoundSink>> sinks,
                                             const ClipRenderOptions& options,
                                             ProgressSink& progress) {
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

std::ptrdiff_t ClipRendering::windows() const {
  return count_windows(stream_.model_samples(), shape_);
}

std::ptrdiff_t ClipRendering::start_of(std::ptrdiff_t index) const {
  return index * (shape_.samples - shape_.overlap);
}

ClipRendering::Moment ClipRendering::read(std::ptrdiff_t index) {
  Moment moment;
  moment.middle_s =
      (static_cast<double>(start_of(index)) + static_cast<double>(shape_.samples) / 2) /
      shape_.sample_rate_hz;
  moment.sound = stream_.window(start_of(index), shape_.samples, shape_.context);
  if (reading_.picture) moment.picture = reading_.picture(moment.middle_s);
  return moment;
}

std::vector<Waveform> ClipRendering::synthesize_all(const Moment& moment, std::ptrdiff_t start) {
  synthesizer_.observe(
      {.sound = moment.sound.primary,
       .picture = moment.picture,
       .speaker_box = reading_.speaker_box ? reading_.speaker_box(moment.middle_s) : std::nullopt,
       .speaker_m = reading_.speaker_m,
       .world_from_source = reading_.world_from_source});
  std::vector<Waveform> results;
  for (const EarpointPath& path : targets_) {
    results.push_back(synthesize(synthesizer_, path, shape_, start));
  }
  return results;
}

void ClipRendering::write(const Moment& moment, std::span<const Waveform> results) {
  const Waveform primary = without_context(moment.sound.primary, shape_);
  std::ptrdiff_t needed = reading_.survey.samples;
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    outputs_[i].add_window(primary, results[i], moment.sound.ambient, stream_);
    needed = std::min(needed, outputs_[i].written());
  }
  stream_.drop_high_band_before(needed);
}

}  // namespace earpoint
