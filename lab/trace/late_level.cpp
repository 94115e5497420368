#include "late_level.h"

#include <algorithm>
#include <cmath>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kStretch_db = 4.0;
constexpr double kMostGain = 4.0;  // 12 dB: a larger correction would amplify a gap, not noise

// Stretches of time, [begin, end) in points of the envelope.
struct Stretch {
  std::size_t begin = 0;
  std::size_t end = 0;
};

// Cuts a decay into stretches of kStretch_db, but not shorter than the band needs.
std::vector<Stretch> cut(std::span<const double> power, double shortest_points) {
  std::vector<double> backward(power.size() + 1);
  for (std::size_t i = power.size(); i-- > 0;) backward[i] = backward[i + 1] + power[i];
  const double step = std::pow(10.0, -kStretch_db / 10.0);
  std::vector<Stretch> stretches;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < power.size(); ++i) {
    const bool long_enough = static_cast<double>(i + 1 - begin) >= shortest_points;
    if (!long_enough || backward[i + 1] > step * backward[begin]) continue;
    stretches.push_back({begin, i + 1});
    begin = i + 1;
  }
  if (begin < power.size()) stretches.push_back({begin, power.size()});
  return stretches;
}

// Adds a band with a gain that is linear between the middles of the stretches.
void add_levelled(std::span<const float> band, std::span<const double> middles,
                  std::span<const double> gains, std::span<float> out) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto t = static_cast<double>(i);
    while (next < middles.size() && middles[next] < t) ++next;
    double gain;
    if (next == 0) {
      gain = gains.front();
    } else if (next == middles.size()) {
      gain = gains.back();
    } else {
      const double share = (t - middles[next - 1]) / (middles[next] - middles[next - 1]);
      gain = std::lerp(gains[next - 1], gains[next], share);
    }
    out[i] += static_cast<float>(gain) * band[i];
  }
}

/// Gains at the middles of stretches, in samples.
struct Levels {
  std::vector<double> middles;
  std::vector<double> gains;
};

// Gains that bring a band's signals to their power, for each stretch.
Levels find_levels(std::span<const double> power, double hop_samples, double shortest_points,
                   std::size_t samples, std::span<const std::vector<float>> signals) {
  Levels levels;
  for (const Stretch& stretch : cut(power, shortest_points)) {
    const auto sample_at = [&](std::size_t point) {
      return std::min(samples, static_cast<std::size_t>(static_cast<double>(point) * hop_samples));
    };
    const std::size_t begin = sample_at(stretch.begin);
    const std::size_t end = sample_at(stretch.end);
    double wanted = 0.0;
    for (std::size_t i = stretch.begin; i < stretch.end; ++i) wanted += power[i] * hop_samples;
    double found = 0.0;
    for (const std::vector<float>& signal : signals) {
      for (std::size_t i = begin; i < end; ++i) {
        found += static_cast<double>(signal[i]) * static_cast<double>(signal[i]);
      }
    }
    if (wanted <= 0.0 || found <= 0.0) continue;
    levels.middles.push_back(static_cast<double>(begin + end) / 2.0);
    levels.gains.push_back(std::clamp(std::sqrt(wanted / found), 1.0 / kMostGain, kMostGain));
  }
  return levels;
}

}  // namespace

BandOverlap::BandOverlap(const OctaveBank& bank) {
  // Mean over the whole circle of frequencies, of which the bins are one half.
  const double per_bin = 1.0 / (bank.bins() - 1);
  for (int b = 0; b < kOctaveBands; ++b) {
    const std::span<const float> own = bank.weights(b);
    for (int bin = 0; bin < bank.bins(); ++bin) {
      const double w = own[bin];
      const double up = b + 1 < kOctaveBands ? bank.weights(b + 1)[bin] : 0.0F;
      const double down = b > 0 ? bank.weights(b - 1)[bin] : 0.0F;
      own_[b] += static_cast<float>(w * w * w * w * per_bin);
      above_[b] += static_cast<float>(2.0 * w * w * w * up * per_bin);
      below_[b] += static_cast<float>(2.0 * w * w * w * down * per_bin);
      far_above_[b] += static_cast<float>(w * w * up * up * per_bin);
      far_below_[b] += static_cast<float>(w * w * down * down * per_bin);
    }
  }
}

BandArray BandOverlap::through(const BandArray& powers) const {
  BandArray result;
  for (int b = 0; b < kOctaveBands; ++b) {
    const float own = powers[b];
    const float up = b + 1 < kOctaveBands ? powers[b + 1] : 0.0F;
    const float down = b > 0 ? powers[b - 1] : 0.0F;
    result[b] = own_[b] * own + far_above_[b] * up + far_below_[b] * down +
                above_[b] * std::sqrt(own * up) + below_[b] * std::sqrt(own * down);
  }
  return result;
}

void level_noise(std::span<const BandArray> expected, double hop_samples, const OctaveBank& bank,
                 int sample_rate_hz, RealFft<float>& fft, std::span<std::vector<float>> channels) {
  const std::size_t samples = channels.front().size();
  const auto size = static_cast<std::size_t>(fft.size());
  EARPOINT_CHECK(samples <= size);
  std::vector<std::vector<std::complex<float>>> spectra;
  std::vector<float> padded(size);
  for (std::vector<float>& channel : channels) {
    std::copy(channel.begin(), channel.end(), padded.begin());
    std::fill(padded.begin() + static_cast<std::ptrdiff_t>(samples), padded.end(), 0.0F);
    fft.forward(padded, spectra.emplace_back(fft.bins()));
    std::fill(channel.begin(), channel.end(), 0.0F);
  }
  std::vector<std::complex<float>> part(fft.bins());
  std::vector<std::vector<float>> bands(channels.size(), std::vector<float>(size));
  for (int band = 0; band < kOctaveBands; ++band) {
    const std::span<const float> weights = bank.weights(band);
    for (std::size_t c = 0; c < channels.size(); ++c) {
      for (std::size_t bin = 0; bin < part.size(); ++bin)
        part[bin] = spectra[c][bin] * weights[bin];
      fft.inverse(part, bands[c]);
    }
    std::vector<double> power(expected.size());
    for (std::size_t i = 0; i < power.size(); ++i) power[i] = expected[i][band];
    // Two over the bandwidth, that is, four degrees of freedom.
    const double shortest_s = 2.0 / (kOctaveBandCentresHz[band] / std::sqrt(2.0));
    const Levels levels =
        find_levels(power, hop_samples, shortest_s * sample_rate_hz / hop_samples, samples, bands);
    if (levels.gains.empty()) continue;
    for (std::size_t c = 0; c < channels.size(); ++c) {
      add_levelled(bands[c], levels.middles, levels.gains, channels[c]);
    }
  }
}

}  // namespace earpoint
