#include <earpoint/trace/moving_sound.h>

#include "early_motion.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include <earpoint/audio/fft.h>
#include <earpoint/error.h>
#include <earpoint/spatial/air_absorption.h>

namespace earpoint {
namespace {

// Arrivals whose delays follow the motion: this number of the strongest, this soon after the first.
constexpr std::size_t kMostEarly = 48;
constexpr double kEarly_s = 0.05;

struct SplitResponse {
  std::vector<Arrival> early;
  PointResponse rest;
};

float strength(const Arrival& arrival) {
  float most = 0.0F;
  for (const float gain : arrival.gain) most = std::max(most, std::abs(gain));
  return most;
}

SplitResponse split(const PointResponse& response) {
  SplitResponse parts;
  parts.rest.distance_m = response.distance_m;
  parts.rest.sees_source = response.sees_source;
  parts.rest.late = response.late;
  if (response.arrivals.empty()) return parts;
  const double last_s = response.arrivals.front().delay_s + kEarly_s;
  std::vector<float> strengths;
  for (const Arrival& arrival : response.arrivals) {
    if (arrival.delay_s <= last_s) strengths.push_back(strength(arrival));
  }
  float least = 0.0F;
  if (strengths.size() > kMostEarly) {
    std::ranges::nth_element(strengths, strengths.begin() + kMostEarly - 1, std::greater<>());
    least = strengths[kMostEarly - 1];
  }
  for (const Arrival& arrival : response.arrivals) {
    const bool early =
        arrival.delay_s <= last_s && strength(arrival) >= least && parts.early.size() < kMostEarly;
    (early ? parts.early : parts.rest.arrivals).push_back(arrival);
  }
  return parts;
}

// Adds the part of a sound in a window, convolved with a fixed response.
void add_convolved(std::span<const float> sound, const MotionWindow& window,
                   const Waveform& response, std::span<std::vector<float>> channels) {
  const std::ptrdiff_t taps = response.samples();
  const std::ptrdiff_t start = window.begin - taps;
  RealFft<float> fft(fast_fft_size(static_cast<int>(window.end - start + taps)));
  std::vector<float> wave(fft.size());
  std::vector<std::complex<float>> input(fft.bins());
  std::vector<std::complex<float>> filter(fft.bins());
  const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, start);
  const std::ptrdiff_t last = std::min(std::ssize(sound), window.end);
  if (first >= last) return;
  std::copy(sound.begin() + first, sound.begin() + last, wave.begin() + (first - start));
  fft.forward(wave, input);
  for (int c = 0; c < response.channels(); ++c) {
    std::ranges::fill(wave, 0.0F);
    std::ranges::copy(response.channel(c), wave.begin());
    fft.forward(wave, filter);
    for (std::size_t bin = 0; bin < filter.size(); ++bin) filter[bin] *= input[bin];
    fft.inverse(filter, wave);
    for (std::ptrdiff_t i = window.begin; i < window.end; ++i) {
      channels[c][i] += window.weight(i) * wave[i - start];
    }
  }
}

int channel_count(const Microphone& microphone) {
  if (microphone.ears) return 2;
  if (!microphone.ambisonic_order) return 1;
  return (*microphone.ambisonic_order + 1) * (*microphone.ambisonic_order + 1);
}

}  // namespace

void trace_motion(const AcousticScene& scene, const Source& source, const Motion& motion, int steps,
                  const TraceOptions& options, ThreadPool& pool,
                  const std::function<void(int step, const PointResponse& response)>& handle) {
  EARPOINT_CHECK(steps > 0 && motion.step_s > 0.0);
  // While the source does not move, one set of rays serves several steps.
  constexpr std::size_t kMostTogether = 16;
  for (int step = 0; step < steps;) {
    Source here = source;
    here.world_from_source = motion.world_from_source(step * motion.step_s);
    std::vector<Vector3> listeners;
    int next = step;
    do {
      listeners.push_back(motion.world_from_listener(next * motion.step_s).position_m);
      ++next;
    } while (next < steps && listeners.size() < kMostTogether &&
             motion.world_from_source(next * motion.step_s) == here.world_from_source);
    const TraceResult traced = trace(scene, {&here, 1}, listeners, options, pool);
    for (const PointResponse& response : traced.responses[0]) handle(step++, response);
  }
}

struct MovingSound::State {
  State(std::vector<float> samples, Motion along, const RenderOptions& render_options,
        const Air& air, Microphone hears)
      : sound(std::move(samples)),
        motion(std::move(along)),
        options(render_options),
        microphone(std::move(hears)),
        synthesizer(render_options),
        early(sound, motion, microphone, speed_of_sound_m_per_s(air)) {
    const auto response =
        static_cast<std::size_t>(std::lround(options.duration_s * options.sample_rate_hz));
    channels.assign(channel_count(microphone), std::vector<float>(sound.size() + response));
  }

  [[nodiscard]] MotionWindow window(int step) const {
    MotionWindow window{.time_s = step * motion.step_s,
                        .step_s = motion.step_s,
                        .sample_rate_hz = options.sample_rate_hz};
    const auto sample_at = [&](double time_s) {
      const auto sample = static_cast<std::ptrdiff_t>(std::ceil(time_s * options.sample_rate_hz));
      return std::clamp<std::ptrdiff_t>(sample, 0, std::ssize(channels.front()));
    };
    window.begin = sample_at(window.time_s - window.step_s);
    window.end = sample_at(window.time_s + window.step_s);
    return window;
  }

  [[nodiscard]] Waveform render(const PointResponse& response, const Quaternion& turn) const {
    if (microphone.ears) return synthesizer.binaural(response, turn, *microphone.ears, 0);
    if (microphone.ambisonic_order) {
      return synthesizer.ambisonic(response, turn, *microphone.ambisonic_order, 0);
    }
    return synthesizer.mono(response, 0);
  }

  std::vector<float> sound;
  Motion motion;
  RenderOptions options;
  Microphone microphone;
  ResponseSynthesizer synthesizer;
  EarlyMotion early;
  std::vector<std::vector<float>> channels;
};

MovingSound::MovingSound(std::vector<float> sound, Motion motion, const RenderOptions& options,
                         const Air& air, Microphone microphone) {
  EARPOINT_CHECK(motion.step_s > 0.0 && motion.world_from_source && motion.world_from_listener);
  EARPOINT_CHECK(!(microphone.ears && microphone.ambisonic_order));
  EARPOINT_CHECK(!microphone.ears || microphone.ears->sample_rate_hz() == options.sample_rate_hz);
  state_ = std::make_unique<State>(std::move(sound), std::move(motion), options, air,
                                   std::move(microphone));
}
MovingSound::~MovingSound() = default;
MovingSound::MovingSound(MovingSound&&) noexcept = default;
MovingSound& MovingSound::operator=(MovingSound&&) noexcept = default;

int MovingSound::steps() const {
  const double duration_s =
      static_cast<double>(state_->channels.front().size()) / state_->options.sample_rate_hz;
  return 1 + static_cast<int>(std::ceil(duration_s / state_->motion.step_s));
}

void MovingSound::add(int step, const PointResponse& response) {
  EARPOINT_CHECK(step >= 0 && step < steps());
  State& state = *state_;
  const MotionWindow window = state.window(step);
  if (window.begin >= window.end) return;
  const SplitResponse parts = split(response);
  state.early.add(window, parts.early, state.channels);
  const Quaternion turn = state.motion.world_from_listener(window.time_s).orientation;
  add_convolved(state.sound, window, state.render(parts.rest, turn), state.channels);
}

Waveform MovingSound::take() {
  const std::vector<std::vector<float>>& channels = state_->channels;
  Waveform waveform(static_cast<int>(channels.size()), std::ssize(channels.front()),
                    state_->options.sample_rate_hz);
  for (int c = 0; c < waveform.channels(); ++c) {
    std::ranges::copy(channels[c], waveform.channel(c).begin());
  }
  return waveform;
}

Waveform trace_motion(const AcousticScene& scene, const Source& source, const Motion& motion,
                      std::span<const float> sound, int sample_rate_hz,
                      const Microphone& microphone, const TraceOptions& options, ThreadPool& pool) {
  MovingSound moving(
      {sound.begin(), sound.end()}, motion,
      {.sample_rate_hz = sample_rate_hz, .duration_s = options.duration_s, .seed = options.seed},
      options.air, microphone);
  trace_motion(scene, source, motion, moving.steps(), options, pool,
               [&](int step, const PointResponse& response) { moving.add(step, response); });
  return moving.take();
}

}  // namespace earpoint
