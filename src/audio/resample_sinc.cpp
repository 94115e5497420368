#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <earpoint/audio/resample.h>
#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr int kZeroCrossings = 24;
constexpr double kRolloff = 0.945;

/// One windowed sinc per phase of the output, each with unit sum.
/// @return  shape [new_rate][2 * half_width + old_rate]; rates already without common factor
std::vector<std::vector<double>> sinc_taps(int old_rate, int new_rate, int half_width) {
  const double cutoff = kRolloff * std::min(old_rate, new_rate);
  std::vector<std::vector<double>> taps(new_rate);
  for (int phase = 0; phase < new_rate; ++phase) {
    for (int k = -half_width; k < half_width + old_rate; ++k) {
      const double crossings =
          (-static_cast<double>(phase) / new_rate + static_cast<double>(k) / old_rate) * cutoff;
      const double t = std::clamp(crossings, -double{kZeroCrossings}, double{kZeroCrossings}) * kPi;
      const double window = std::cos(t / (2 * kZeroCrossings));
      const double sinc = t == 0.0 ? 1.0 : std::sin(t) / t;
      taps[phase].push_back(sinc * window * window);
    }
    const double sum = std::accumulate(taps[phase].begin(), taps[phase].end(), 0.0);
    for (double& tap : taps[phase]) tap /= sum;
  }
  return taps;
}

}  // namespace

Waveform resample_sinc(const Waveform& waveform, int sample_rate_hz) {
  EARPOINT_CHECK(sample_rate_hz > 0);
  if (waveform.sample_rate_hz() == sample_rate_hz) return waveform;
  const int divisor = std::gcd(waveform.sample_rate_hz(), sample_rate_hz);
  const int old_rate = waveform.sample_rate_hz() / divisor;
  const int new_rate = sample_rate_hz / divisor;
  const std::ptrdiff_t samples = waveform.samples();
  Waveform result(waveform.channels(), samples * new_rate / old_rate, sample_rate_hz);
  if (result.empty()) return result;

  const double cutoff = kRolloff * std::min(old_rate, new_rate);
  const int half_width = static_cast<int>(std::ceil(kZeroCrossings * old_rate / cutoff));
  const std::vector<std::vector<double>> taps = sinc_taps(old_rate, new_rate, half_width);
  for (int c = 0; c < waveform.channels(); ++c) {
    const std::span<const float> in = waveform.channel(c);
    // The edges are repeated: half_width samples in front, half_width + old_rate behind.
    std::vector<double> padded(
        static_cast<std::size_t>(samples + 2 * std::ptrdiff_t{half_width} + old_rate));
    for (std::ptrdiff_t i = 0; i < std::ssize(padded); ++i) {
      padded[i] = in[std::clamp<std::ptrdiff_t>(i - half_width, 0, samples - 1)];
    }
    const std::span<float> out = result.channel(c);
    for (std::ptrdiff_t i = 0; i < result.samples(); ++i) {
      const std::vector<double>& tap = taps[i % new_rate];
      const double* source = padded.data() + i / new_rate * old_rate;
      out[i] = static_cast<float>(std::inner_product(tap.begin(), tap.end(), source, 0.0));
    }
  }
  return result;
}

}  // namespace earpoint
