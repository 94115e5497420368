#include <earpoint/render/clip_rendering.h>

#include <algorithm>
#include <utility>

#include <earpoint/audio/window_of.h>

namespace earpoint {
namespace {

// Threads wait for each other at the end of a group, which a longer one makes rarer. It also keeps
// more pictures in memory.
constexpr std::ptrdiff_t kWindowsPerThread = 2;

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

/// So many that each of `users` has a synthesizer, or none.
std::vector<std::unique_ptr<AcousticSynthesizer>> twins_of(const AcousticSynthesizer& synthesizer,
                                                           std::ptrdiff_t users) {
  std::vector<std::unique_ptr<AcousticSynthesizer>> twins;
  for (std::ptrdiff_t i = 1; i < users; ++i) {
    std::unique_ptr<AcousticSynthesizer> twin = synthesizer.twin();
    if (!twin) return {};
    twins.push_back(std::move(twin));
  }
  return twins;
}

}  // namespace

ClipRendering::ClipRendering(ClipReading reading, AcousticSynthesizer& synthesizer,
                             std::span<const EarpointPath> targets,
                             const ClipRenderOptions& options)
    : reading_(std::move(reading)),
      targets_(targets),
      shape_(synthesizer.window_shape(reading_.survey.sample_rate_hz)),
      stream_(
          reading_.sound, reading_.survey, shape_.sample_rate_hz,
          {options.ambient, options.ambient_cutoff_hz.value_or(synthesizer.ambient_cutoff_hz())}),
      twins_(twins_of(synthesizer, std::min<std::ptrdiff_t>(options.threads, windows()))),
      synthesizers_{&synthesizer},
      group_(twins_.empty() ? 1 : kWindowsPerThread * (1 + std::ssize(twins_))),
      pool_(twins_.empty() ? std::min(2, options.threads) : 1 + static_cast<int>(twins_.size())) {
  for (const auto& twin : twins_) synthesizers_.push_back(twin.get());
  for (const EarpointPath& path : targets) path.check_covers(reading_.survey.duration_s());
}

std::vector<TargetStream> ClipRendering::run(std::vector<std::unique_ptr<SoundSink>> sinks,
                                             const ClipRenderOptions& options,
                                             ProgressSink& progress) {
  for (std::unique_ptr<SoundSink>& sink : sinks) {
    outputs_.emplace_back(std::move(sink), reading_.survey, shape_, options);
  }
  progress.begin("rendering", reading_.survey.duration_s(), "s");
  std::vector<Window> next = read_group(0);
  std::vector<Window> written;
  for (std::ptrdiff_t first = 0; first < windows(); first += group_) {
    std::vector<Window> group = std::exchange(next, {});
    pool_.run(1 + std::ssize(group), [&](std::ptrdiff_t task, int worker) {
      if (task > 0) {
        // Without twins the group is one window, which any thread may render.
        render(group[task - 1], *synthesizers_[twins_.empty() ? 0 : worker]);
        return;
      }
      for (const Window& window : written) write(window);
      next = read_group(first + group_);
    });
    written = std::move(group);
    // The last window takes its overlap along.
    const std::ptrdiff_t end = next.empty() ? stream_.model_samples() : next.front().start;
    progress.advance(static_cast<double>(end - start_of(first)) / shape_.sample_rate_hz);
  }
  for (const Window& window : written) write(window);
  for (TargetStream& output : outputs_) output.finish(stream_);
  return std::move(outputs_);
}

std::ptrdiff_t ClipRendering::windows() const {
  return count_windows(stream_.model_samples(), shape_);
}

std::ptrdiff_t ClipRendering::start_of(std::ptrdiff_t index) const {
  return index * (shape_.samples - shape_.overlap);
}

ClipRendering::Window ClipRendering::read(std::ptrdiff_t index) {
  Window window;
  window.start = start_of(index);
  window.middle_s = (static_cast<double>(window.start) + static_cast<double>(shape_.samples) / 2) /
                    shape_.sample_rate_hz;
  window.sound = stream_.window(window.start, shape_.samples, shape_.context);
  if (reading_.picture) window.picture = reading_.picture(window.middle_s);
  if (reading_.speaker_box) window.speaker_box = reading_.speaker_box(window.middle_s);
  has_picture_ |= window.picture != nullptr;
  return window;
}

std::vector<ClipRendering::Window> ClipRendering::read_group(std::ptrdiff_t first) {
  std::vector<Window> group;
  const std::ptrdiff_t last = std::min(first + group_, windows());
  for (std::ptrdiff_t index = first; index < last; ++index) group.push_back(read(index));
  return group;
}

void ClipRendering::render(Window& window, AcousticSynthesizer& synthesizer) const {
  synthesizer.observe({.sound = window.sound.primary,
                       .picture = std::exchange(window.picture, nullptr),
                       .speaker_box = window.speaker_box,
                       .speaker_m = reading_.speaker_m,
                       .world_from_source = reading_.world_from_source});
  for (const EarpointPath& path : targets_) {
    window.results.push_back(synthesize(synthesizer, path, shape_, window.start));
  }
}

void ClipRendering::write(const Window& window) {
  const Waveform primary = without_context(window.sound.primary, shape_);
  std::ptrdiff_t needed = reading_.survey.samples;
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    outputs_[i].add_window(primary, window.results[i], window.sound.ambient, stream_);
    needed = std::min(needed, outputs_[i].written());
  }
  stream_.drop_high_band_before(needed);
}

}  // namespace earpoint
