#include <earpoint/record_simulation/device_sound.h>

#include "diffuse_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

// Gains with headroom, so that neither the clap nor a nearby speaker clips: speech at 1 m is at -26
// dB before the gain, 16 dB more at a near microphone.
constexpr float kCameraGain = 0.35F;
constexpr float kMicrophoneGain = 0.1F;

constexpr std::ptrdiff_t kReach = 32;  // samples to either side
constexpr int kPhases = 1024;
constexpr double kCutoff = 0.96;  // of the Nyquist frequency
constexpr double kKaiser = 9.0;

double bessel_i0(double x) {
  double sum = 1.0;
  double term = 1.0;
  for (int k = 1; k < 60; ++k) {
    term *= x * x / (4.0 * k * k);
    sum += term;
  }
  return sum;
}

/// Reads a signal between its samples.
class SincReader {
 public:
  SincReader() : kernel_(static_cast<std::size_t>(kPhases + 1) * 2 * kReach) {
    for (int phase = 0; phase <= kPhases; ++phase) {
      for (int tap = 0; tap < 2 * kReach; ++tap) {
        const double away = tap - (kReach - 1) - static_cast<double>(phase) / kPhases;
        const double u = away / kReach;
        const double window =
            std::abs(u) >= 1.0 ? 0.0
                               : bessel_i0(kKaiser * std::sqrt(1.0 - u * u)) / bessel_i0(kKaiser);
        const double x = kPi * kCutoff * away;
        const double sinc = away == 0.0 ? kCutoff : kCutoff * std::sin(x) / x;
        kernel_[static_cast<std::size_t>(phase) * 2 * kReach + tap] =
            static_cast<float>(window * sinc);
      }
    }
  }

  [[nodiscard]] float at(std::span<const float> signal, double position) const {
    const double whole = std::floor(position);
    const auto first = static_cast<std::ptrdiff_t>(whole) - (kReach - 1);
    const double phase = (position - whole) * kPhases;
    const auto row = static_cast<std::size_t>(phase);
    const auto blend = static_cast<float>(phase - static_cast<double>(row));
    const float* const near = &kernel_[row * 2 * kReach];
    const float* const next = near + 2 * kReach;
    // Separate sums, whose order of addition no compiler changes.
    constexpr int kLanes = 8;
    static_assert(2 * kReach % kLanes == 0);
    std::array<float, kLanes> sums{};
    if (first >= 0 && first + 2 * kReach <= std::ssize(signal)) {
      const float* const samples = &signal[static_cast<std::size_t>(first)];
      for (int tap = 0; tap < 2 * kReach; tap += kLanes) {
        for (int lane = 0; lane < kLanes; ++lane) {
          const int i = tap + lane;
          sums[lane] += (near[i] + blend * (next[i] - near[i])) * samples[i];
        }
      }
    } else {
      for (int tap = 0; tap < 2 * kReach; ++tap) {
        const std::ptrdiff_t i = first + tap;
        if (i < 0 || i >= std::ssize(signal)) continue;
        sums[tap % kLanes] += (near[tap] + blend * (next[tap] - near[tap])) * signal[i];
      }
    }
    return std::accumulate(sums.begin(), sums.end(), 0.0F);
  }

 private:
  std::vector<float> kernel_;  // [phase][tap]
};

const SincReader& reader() {
  static const SincReader only;
  return only;
}

}  // namespace

Waveform recorded_by(const DeviceClock& clock, const Waveform& sound, double end_s) {
  const double rate_hz = sound.sample_rate_hz();
  const auto samples = static_cast<std::ptrdiff_t>(device_time_s(clock, end_s) * rate_hz);
  EARPOINT_CHECK(samples > 0);
  Waveform recorded(sound.channels(), samples, sound.sample_rate_hz());
  for (int c = 0; c < sound.channels(); ++c) {
    for (std::ptrdiff_t i = 0; i < samples; ++i) {
      const double time_s = session_time_s(clock, static_cast<double>(i) / rate_hz);
      recorded.channel(c)[i] = reader().at(sound.channel(c), time_s * rate_hz);
    }
  }
  return recorded;
}

double mean_speech_power(const SessionSound& speech, const SessionPlan& plan) {
  EARPOINT_CHECK(!speech.cameras.empty());
  const Waveform& first = speech.cameras.front();
  std::vector<unsigned char> active(static_cast<std::size_t>(first.samples()));
  for (const Utterance& turn : plan.turns) {
    for (const SpeechInterval& interval : speech_intervals(turn)) {
      const auto begin = std::lround(interval.begin_s * first.sample_rate_hz());
      const auto end = std::lround(interval.end_s * first.sample_rate_hz());
      for (long i = begin; i < end && i < std::ssize(active); ++i) active[i] = 1;
    }
  }
  double sum = 0.0;
  std::int64_t count = 0;
  for (const Waveform& camera : speech.cameras) {
    for (int ear = 0; ear < camera.channels(); ++ear) {
      const std::span<const float> samples = camera.channel(ear);
      for (std::size_t i = 0; i < active.size(); ++i) {
        if (active[i] == 0) continue;
        sum += static_cast<double>(samples[i]) * samples[i];
        ++count;
      }
    }
  }
  return count == 0 ? 0.0 : sum / static_cast<double>(count);
}

struct SessionRecorder::State {
  DiffuseNoise ears;
  DiffuseNoise point;
  float noise_level;

  [[nodiscard]] Waveform record(const DiffuseNoise& noise, float gain, const Waveform& heard,
                                const DeviceClock& clock, double end_s,
                                RandomStream& random) const {
    Waveform sound = recorded_by(clock, heard, end_s);
    const Waveform ambient = noise.make(sound.samples(), random);
    EARPOINT_CHECK(ambient.channels() == sound.channels());
    const std::span<const float> added = ambient.planar();
    const std::span<float> samples = sound.planar();
    for (std::size_t i = 0; i < samples.size(); ++i) {
      samples[i] = gain * (samples[i] + noise_level * added[i]);
    }
    return sound;
  }
};

SessionRecorder::SessionRecorder(const HrtfSet& ears, double noise_power)
    : state_(std::make_unique<const State>(
          State{.ears = DiffuseNoise(ears),
                .point = DiffuseNoise(kDeviceRate_hz),
                .noise_level = static_cast<float>(std::sqrt(noise_power))})) {
  EARPOINT_CHECK(ears.sample_rate_hz() == kDeviceRate_hz && noise_power >= 0.0);
}
SessionRecorder::~SessionRecorder() = default;

Waveform SessionRecorder::camera(const Waveform& heard, const DeviceClock& clock, double end_s,
                                 RandomStream& random) const {
  return state_->record(state_->ears, kCameraGain, heard, clock, end_s, random);
}

Waveform SessionRecorder::microphone(const Waveform& heard, const DeviceClock& clock, double end_s,
                                     RandomStream& random) const {
  return state_->record(state_->point, kMicrophoneGain, heard, clock, end_s, random);
}

}  // namespace earpoint
