#include <earpoint/audio/stream_rate.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

// Attenuation of 100 dB by Kaiser's formula, beta = 0.1102 (A - 8.7).
constexpr double kBeta = 0.1102 * (100.0 - 8.7);

/// Modified Bessel function of the first kind, order 0, by its power series.
double bessel_i0(double x) {
  double sum = 1.0;
  double term = 1.0;
  for (int k = 1; term > 1e-16 * sum; ++k) {
    const double factor = x / (2.0 * k);
    term *= factor * factor;
    sum += term;
  }
  return sum;
}

double sinc(double x) { return x == 0.0 ? 1.0 : std::sin(kPi * x) / (kPi * x); }

/// The filter's response at a time, for an input of unit spacing 1 / from_hz.
double response(double time_s, int from_hz, double cutoff_hz, double half_length_s) {
  const double place = time_s / half_length_s;
  if (std::abs(place) > 1.0) return 0.0;
  const double window = bessel_i0(kBeta * std::sqrt(1.0 - place * place)) / bessel_i0(kBeta);
  return 2.0 * cutoff_hz / from_hz * sinc(2.0 * cutoff_hz * time_s) * window;
}

/// Sums in lanes, so that the compiler can use vectors and every processor adds in the same order.
float dot(const float* a, const float* b, std::ptrdiff_t count) {
  constexpr std::ptrdiff_t kLanes = 16;
  std::array<float, kLanes> sums{};
  std::ptrdiff_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    for (std::ptrdiff_t lane = 0; lane < kLanes; ++lane) sums[lane] += a[i + lane] * b[i + lane];
  }
  for (; i < count; ++i) sums[i % kLanes] += a[i] * b[i];
  return std::accumulate(sums.begin(), sums.end(), 0.0F);
}

}  // namespace

StreamRate::StreamRate(int channels, int from_hz, int to_hz, double delay_s)
    : channels_(channels), from_hz_(from_hz), to_hz_(to_hz) {
  EARPOINT_CHECK(channels > 0);
  for (const int rate_hz : {from_hz, to_hz}) {
    EARPOINT_CHECK(rate_hz >= 8000 && rate_hz <= 384000 && rate_hz % 50 == 0);
  }
  if (from_hz == to_hz) return;
  const int common_hz = std::gcd(from_hz, to_hz);
  phases_ = to_hz / common_hz;
  step_ = from_hz / common_hz;
  delay_s_ = delay_s;
  const double delay = delay_s * from_hz;  // in samples of the input
  taps_ = static_cast<std::ptrdiff_t>(std::floor(2.0 * delay)) + 2;
  const double cutoff_hz = std::min(from_hz, to_hz) / 2.0;
  kernel_.resize(static_cast<std::size_t>(phases_ * taps_));
  for (std::ptrdiff_t phase = 0; phase < phases_; ++phase) {
    const auto row = std::span(kernel_).subspan(static_cast<std::size_t>(phase * taps_),
                                                static_cast<std::size_t>(taps_));
    // Without the delay, an output sample lies phase / phases_ after the newest input sample.
    const double late = static_cast<double>(phase) / static_cast<double>(phases_) - delay;
    double sum = 0.0;
    std::vector<double> exact(row.size());
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const double sample = static_cast<double>(i) - static_cast<double>(taps_ - 1);
      exact[i] = response((late - sample) / from_hz, from_hz, cutoff_hz, delay_s);
      sum += exact[i];
    }
    // Every phase passes a constant unchanged.
    for (std::size_t i = 0; i < exact.size(); ++i) row[i] = static_cast<float>(exact[i] / sum);
  }
  past_.resize(static_cast<std::size_t>(channels * (taps_ - 1)));
}

void StreamRate::reset() { std::ranges::fill(past_, 0.0F); }

void StreamRate::process(std::span<const float> in, std::span<float> out) {
  const auto samples = static_cast<std::ptrdiff_t>(in.size()) / channels_;
  const auto made = static_cast<std::ptrdiff_t>(out.size()) / channels_;
  EARPOINT_CHECK(made * from_hz_ == samples * to_hz_);
  if (from_hz_ == to_hz_) {
    std::ranges::copy(in, out.begin());
    return;
  }
  const std::ptrdiff_t kept = taps_ - 1;
  row_.resize(static_cast<std::size_t>(kept + samples));
  for (int c = 0; c < channels_; ++c) {
    std::copy_n(past_.begin() + c * kept, kept, row_.begin());
    std::copy_n(in.begin() + c * samples, samples, row_.begin() + kept);
    for (std::ptrdiff_t j = 0; j < made; ++j) {
      const std::ptrdiff_t place = j * step_;
      const float* const taps = kernel_.data() + place % phases_ * taps_;
      out[static_cast<std::size_t>(c * made + j)] = dot(taps, row_.data() + place / phases_, taps_);
    }
    std::copy_n(row_.end() - kept, kept, past_.begin() + c * kept);
  }
}

}  // namespace earpoint
