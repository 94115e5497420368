#include "delayed_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr int kTaps = 16;
constexpr int kPhases = 1024;
constexpr double kBeta = 8.0;  // of the Kaiser window

double kernel(double x) {
  const double place = x / (kTaps / 2.0);
  if (std::abs(place) >= 1.0) return 0.0;
  const double window = std::cyl_bessel_i(0.0, kBeta * std::sqrt(1.0 - place * place)) /
                        std::cyl_bessel_i(0.0, kBeta);
  return window * (x == 0.0 ? 1.0 : std::sin(kPi * x) / (kPi * x));
}

std::vector<float> make_kernel() {
  std::vector<float> table;
  table.reserve(static_cast<std::size_t>(kPhases + 1) * kTaps);
  for (int phase = 0; phase <= kPhases; ++phase) {
    for (int tap = 0; tap < kTaps; ++tap) {
      const int away = tap - (kTaps / 2 - 1);
      const double x = away - static_cast<double>(phase) / kPhases;
      table.push_back(static_cast<float>(kernel(x)));
    }
  }
  return table;
}

/// All taps at once, in sums that the compiler computes side by side.
float product(const float* low, const float* high, float between, const float* signal) {
  constexpr int kLanes = 4;
  std::array<float, kLanes> sums{};
  for (int tap = 0; tap < kTaps; tap += kLanes) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const int i = tap + lane;
      sums[static_cast<std::size_t>(lane)] += (low[i] + between * (high[i] - low[i])) * signal[i];
    }
  }
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

}  // namespace

DelayedReader::DelayedReader() {
  // Takes milliseconds, and there is a reader for every window of every moving sound.
  static const std::vector<float> table = make_kernel();
  kernel_ = table;
}

float DelayedReader::at(std::span<const float> signal, double position) const {
  const double whole = std::floor(position);
  const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(whole) - (kTaps / 2 - 1);
  const double place = (position - whole) * kPhases;
  const auto phase = static_cast<std::size_t>(place);
  const auto between = static_cast<float>(place - static_cast<double>(phase));
  const float* const low = &kernel_[phase * kTaps];
  const float* const high = low + kTaps;
  const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, -first);
  const std::ptrdiff_t end = std::min<std::ptrdiff_t>(kTaps, std::ssize(signal) - first);
  if (begin == 0 && end == kTaps) return product(low, high, between, &signal[first]);
  float sum = 0.0F;
  for (std::ptrdiff_t tap = begin; tap < end; ++tap) {
    sum += (low[tap] + between * (high[tap] - low[tap])) * signal[first + tap];
  }
  return sum;
}

double SmoothCurve::at(double time_s) const {
  const double place = (time_s - first_time_s_) / step_s_;
  const auto last = std::ssize(values_) - 3;
  const auto i = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(place), 1, last);
  EARPOINT_DCHECK(last >= 1);
  const double t = place - static_cast<double>(i);
  const double a = values_[i - 1];
  const double b = values_[i];
  const double c = values_[i + 1];
  const double d = values_[i + 2];
  return b +
         0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)));
}

}  // namespace earpoint
