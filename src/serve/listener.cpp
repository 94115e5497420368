#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <earpoint/core/error.h>
#include <earpoint/serve/listener.h>

namespace earpoint {
namespace {

constexpr double kWarmUp_s = 0.5;
constexpr double kPoseStep_s = 0.01;

}  // namespace

std::optional<ListenMethod> listen_method(std::string_view name) {
  if (name == "input") return ListenMethod::input;
  if (name == "gtf") return ListenMethod::gtf;
  return std::nullopt;
}

Listener::Listener(const ServedClip& clip)
    : clip_(clip),
      stream_(clip.weights, {.sample_rate_hz = clip.sound.sample_rate_hz(),
                             .horizontal_fov_rad = clip.horizontal_fov_rad}) {
  stream_.see(clip.picture.get(), clip.speaker_box);
  stream_.place_speaker(clip.speaker_m);
}

Waveform Listener::source(std::ptrdiff_t start, std::ptrdiff_t samples) const {
  Waveform part(2, samples, clip_.sound.sample_rate_hz());
  const std::ptrdiff_t first = std::clamp<std::ptrdiff_t>(start, 0, clip_.sound.samples());
  const std::ptrdiff_t end =
      std::clamp<std::ptrdiff_t>(start + samples, first, clip_.sound.samples());
  for (int ear = 0; ear < 2; ++ear) {
    std::copy(clip_.sound.channel(ear).begin() + first, clip_.sound.channel(ear).begin() + end,
              part.channel(ear).begin() + (first - start));
  }
  return part;
}

void Listener::leap(std::ptrdiff_t start, const Pose& pose) {
  stream_.reset();
  stream_.move_to(pose);
  pose_ = pose;
  const std::ptrdiff_t latency = stream_.latency_samples();
  const auto warm_up = static_cast<std::ptrdiff_t>(kWarmUp_s * clip_.sound.sample_rate_hz());
  Waveform before = source(start - warm_up, warm_up + latency);
  stream_.process({before.channel(0), before.channel(1)}, {before.channel(0), before.channel(1)});
}

Waveform Listener::rendered(std::ptrdiff_t start, std::ptrdiff_t samples, const Pose& pose) {
  Waveform part = source(start + stream_.latency_samples(), samples);
  const auto step = static_cast<std::ptrdiff_t>(kPoseStep_s * clip_.sound.sample_rate_hz());
  for (std::ptrdiff_t done = 0; done < samples; done += step) {
    const auto first = static_cast<std::size_t>(done);
    const auto count = static_cast<std::size_t>(std::min(step, samples - done));
    const auto end = static_cast<double>(first + count);
    stream_.move_to(interpolate(pose_, pose, end / static_cast<double>(samples)));
    const auto left = part.channel(0).subspan(first, count);
    const auto right = part.channel(1).subspan(first, count);
    stream_.process({left, right}, {left, right});
  }
  pose_ = pose;
  return part;
}

Waveform Listener::listen(std::ptrdiff_t start, std::ptrdiff_t samples,
                          const Pose& source_from_target, ListenMethod method) {
  EARPOINT_CHECK(samples > 0 && samples <= clip_.sound.sample_rate_hz());
  const bool joins = start == next_;
  if (!joins) {
    leap(start, source_from_target);
    method_ = method;
  }
  next_ = start + samples;
  Waveform there = rendered(start, samples, source_from_target);
  Waveform here = source(start, samples);
  const ListenMethod before = std::exchange(method_, method);
  if (before == method) return method == ListenMethod::gtf ? there : here;
  // From one method to the other within the part.
  const bool to_there = method == ListenMethod::gtf;
  for (int ear = 0; ear < 2; ++ear) {
    for (std::ptrdiff_t i = 0; i < samples; ++i) {
      const float rising = static_cast<float>(i + 1) / static_cast<float>(samples);
      const float share = to_there ? rising : 1.0F - rising;
      there.channel(ear)[i] = std::lerp(here.channel(ear)[i], there.channel(ear)[i], share);
    }
  }
  return there;
}

}  // namespace earpoint
