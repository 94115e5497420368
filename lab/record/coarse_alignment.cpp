#include "coarse_alignment.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>

#include <earpoint/audio/fft.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kBlock_s = 20.0;
constexpr double kBlockSearch_s = 0.12;
/// Longer sessions are first matched by this much of their beginning, as drift smears the peak.
constexpr double kGlobal_s = 600.0;
constexpr double kBlockSignificance = 5.0;
constexpr double kMostDriftPpm = 500.0;

std::ptrdiff_t hops(double seconds) { return std::lround(seconds / kOnsetHop_s); }

/// Power of differences between samples, all channels together, in steps of `hop` samples.
std::vector<double> step_power(const Waveform& sound, std::ptrdiff_t begin, std::ptrdiff_t end,
                               std::ptrdiff_t hop) {
  constexpr float kPreEmphasis = 0.95F;
  std::vector<double> power(static_cast<std::size_t>((end - begin) / hop));
  for (int c = 0; c < sound.channels(); ++c) {
    const auto x = sound.channel(c);
    for (std::size_t i = 0; i < power.size(); ++i) {
      const std::ptrdiff_t first = begin + static_cast<std::ptrdiff_t>(i) * hop;
      double sum = 0.0;
      for (std::ptrdiff_t n = std::max(first, std::ptrdiff_t{1}); n < first + hop; ++n) {
        const float d = x[n] - kPreEmphasis * x[n - 1];
        sum += static_cast<double>(d) * d;
      }
      power[i] += sum;
    }
  }
  return power;
}

struct CorrelationPeak {
  std::ptrdiff_t lag = 0;  ///< of the device, in hops: device[n + lag] matches reference[n]
  double significance = 0.0;
};

/// @param least, most  lags to look at
CorrelationPeak correlate(std::span<const float> device, std::span<const float> reference,
                          std::ptrdiff_t least, std::ptrdiff_t most) {
  const int size = fast_fft_size(static_cast<int>(device.size() + reference.size()));
  RealFft<float> fft(size);
  std::vector<float> signal(static_cast<std::size_t>(size));
  std::vector<std::complex<float>> a(static_cast<std::size_t>(fft.bins()));
  std::vector<std::complex<float>> b(a.size());
  std::ranges::copy(device, signal.begin());
  fft.forward(signal, a);
  std::ranges::fill(signal, 0.0F);
  std::ranges::copy(reference, signal.begin());
  fft.forward(signal, b);
  for (std::size_t k = 0; k < a.size(); ++k) a[k] *= std::conj(b[k]);
  fft.inverse(a, signal);

  // Sums ten milliseconds, as drift and different distances spread the peak.
  const auto value = [&](std::ptrdiff_t lag) {
    float sum = 0.0F;
    for (std::ptrdiff_t d = -2; d <= 2; ++d) {
      const std::ptrdiff_t at = lag + d;
      sum += signal[static_cast<std::size_t>(at < 0 ? at + size : at)];
    }
    return sum;
  };
  CorrelationPeak peak;
  double best = -1.0;
  double sum = 0.0;
  double squares = 0.0;
  for (std::ptrdiff_t lag = least; lag <= most; ++lag) {
    const double v = value(lag);
    sum += v;
    squares += v * v;
    if (v <= best) continue;
    best = v;
    peak.lag = lag;
  }
  const auto count = static_cast<double>(most - least + 1);
  const double mean = sum / count;
  const double deviation = std::sqrt(std::max(squares / count - mean * mean, 1e-30));
  peak.significance = (best - mean) / deviation;
  return peak;
}

/// A block of the reference and its delay in the device.
struct BlockLag {
  double reference_s = 0.0;
  double lag_s = 0.0;
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Theil and Sen's line: half of the blocks may be wrong.
DeviceClock line_through(const std::vector<BlockLag>& blocks, double lag_s) {
  DeviceClock clock{.name = {}, .offset_s = -lag_s, .drift_ppm = 0.0};
  if (blocks.empty()) return clock;
  std::vector<double> slopes;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    for (std::size_t j = i + 1; j < blocks.size(); ++j) {
      slopes.push_back((blocks[j].lag_s - blocks[i].lag_s) /
                       (blocks[j].reference_s - blocks[i].reference_s));
    }
  }
  // No drift from few blocks: a few milliseconds over a short time may also be a walking person.
  constexpr std::size_t kFewest = 15;
  const double slope = slopes.size() < kFewest ? 0.0 : median(slopes);
  if (std::abs(slope) < kMostDriftPpm * 1e-6) clock.drift_ppm = slope * 1e6;
  std::vector<double> lags;
  lags.reserve(blocks.size());
  for (const BlockLag& block : blocks) {
    lags.push_back(block.lag_s - clock.drift_ppm * 1e-6 * block.reference_s);
  }
  // device = reference + lag + drift reference, hence session time 0 of the device:
  clock.offset_s = -median(lags) / (1.0 + clock.drift_ppm * 1e-6);
  return clock;
}

}  // namespace

std::vector<float> onset_strength(const Waveform& sound) {
  const auto hop = static_cast<std::ptrdiff_t>(std::lround(kOnsetHop_s * sound.sample_rate_hz()));
  const std::vector<double> power = step_power(sound, 0, sound.samples(), hop);
  std::vector<float> strength(power.size());
  constexpr std::ptrdiff_t kBefore = 15;
  constexpr std::ptrdiff_t kAfter = 5;
  if (std::ssize(power) <= kBefore + kAfter) return strength;

  std::vector<double> sorted = power;
  const auto quiet = sorted.begin() + std::ssize(sorted) / 5;
  std::nth_element(sorted.begin(), quiet, sorted.end());
  const double floor = *quiet + 1e-12;
  std::vector<double> level_db(power.size() + 1);  // summed up
  for (std::size_t i = 0; i < power.size(); ++i) {
    level_db[i + 1] = level_db[i] + 10.0 * std::log10(power[i] + floor);
  }
  for (std::ptrdiff_t i = kBefore; i + kAfter < std::ssize(power); ++i) {
    const double before = (level_db[i] - level_db[i - kBefore]) / kBefore;
    const double after = (level_db[i + kAfter] - level_db[i]) / kAfter;
    strength[i] = static_cast<float>(std::max(after - before, 0.0));
  }
  const float mean =
      std::accumulate(strength.begin(), strength.end(), 0.0F) / static_cast<float>(strength.size());
  for (float& value : strength) value -= mean;
  return strength;
}

CoarseClock coarse_clock(std::span<const float> device, std::span<const float> reference) {
  EARPOINT_CHECK(!device.empty() && !reference.empty());
  const auto beginning = static_cast<std::size_t>(hops(kGlobal_s));
  const auto early_device = device.first(std::min(beginning, device.size()));
  const auto early_reference = reference.first(std::min(beginning, reference.size()));
  const CorrelationPeak global =
      correlate(early_device, early_reference, -std::ssize(early_reference) + hops(1.0),
                std::ssize(early_device) - hops(1.0));
  CoarseClock result;
  result.significance = global.significance;
  const double lag_s = static_cast<double>(global.lag) * kOnsetHop_s;

  std::vector<BlockLag> blocks;
  DeviceClock line = line_through(blocks, lag_s);
  const std::ptrdiff_t block = hops(kBlock_s);
  const std::ptrdiff_t search = hops(kBlockSearch_s);
  for (std::ptrdiff_t begin = 0; begin + block <= std::ssize(reference); begin += block) {
    const double middle_s =
        (static_cast<double>(begin) + 0.5 * static_cast<double>(block)) * kOnsetHop_s;
    const double predicted_s = device_time_s(line, middle_s) - middle_s;
    const std::ptrdiff_t start = begin + std::lround(predicted_s / kOnsetHop_s) - search;
    if (start < 0 || start + block + 2 * search > std::ssize(device)) continue;
    const CorrelationPeak peak = correlate(device.subspan(start, block + 2 * search),
                                           reference.subspan(begin, block), 0, 2 * search);
    if (peak.significance < kBlockSignificance) continue;
    blocks.push_back({middle_s, static_cast<double>(start + peak.lag - begin) * kOnsetHop_s});
    line = line_through(blocks, lag_s);
  }
  result.clock = line;
  return result;
}

std::optional<Clap> find_clap(const Waveform& sound, double from_s, double to_s) {
  constexpr double kStep_s = 0.0005;
  constexpr std::ptrdiff_t kBefore = 60;
  constexpr std::ptrdiff_t kRise = 6;  // the loudest step is up to 3 ms after the first
  constexpr double kOfTop = 0.1;
  constexpr double kNothing = 1e-12;
  const double rate = sound.sample_rate_hz();
  const auto hop = static_cast<std::ptrdiff_t>(std::lround(kStep_s * rate));
  const auto begin =
      std::max(std::ptrdiff_t{0}, static_cast<std::ptrdiff_t>(from_s * rate) - kBefore * hop);
  const auto end = std::min(sound.samples(), static_cast<std::ptrdiff_t>(to_s * rate));
  if (end - begin <= (kBefore + 1) * hop) return std::nullopt;
  const std::vector<double> power = step_power(sound, begin, end, hop);

  std::optional<Clap> clap;
  double best = 0.0;
  for (std::ptrdiff_t i = kBefore; i < std::ssize(power); ++i) {
    const double before =
        *std::max_element(power.begin() + i - kBefore, power.begin() + i - kRise) + kNothing;
    // Loud and steep, as speech rises slowly and connector clicks are weak.
    const double score = std::sqrt(power[i]) * std::log10(1.0 + power[i] / before);
    if (score <= best) continue;
    best = score;
    std::ptrdiff_t first = i - kRise;
    while (power[first] < kOfTop * power[i]) ++first;
    clap =
        Clap{static_cast<double>(begin + first * hop) / rate, 10.0 * std::log10(power[i] / before)};
  }
  return clap;
}

}  // namespace earpoint
