#include "wave_sum.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include <earpoint/core/pose.h>

namespace earpoint {
namespace {

using Complex = std::complex<double>;

// Gains are changed by no more than this factor: where waves cancel almost wholly, their small sum
// says little.
constexpr double kLargestScale = 3.0;

// Sound further apart adds up by its energy: the lowest octave's mean is a quarter of its peak.
constexpr double kApart_m = 4.0;

// The mean of exp(-i k distance) over an octave of even spectrum.
Complex mean_turn(int band, double distance_m, double speed_m_per_s) {
  const double centre_hz = kOctaveBandCentresHz[band];
  const double low_hz = centre_hz * std::sqrt(0.5);
  const double high_hz = centre_hz * std::sqrt(2.0);
  const double middle = kPi * (low_hz + high_hz) / speed_m_per_s * distance_m;
  const double half = kPi * (high_hz - low_hz) / speed_m_per_s * distance_m;
  const double envelope = std::abs(half) < 1e-6 ? 1.0 : std::sin(half) / half;
  return envelope * std::polar(1.0, -middle);
}

// One wave in one band.
struct Part {
  double distance_m = 0.0;
  Complex pressure;  // its magnitude is the root of the band's energy
  double gain = 0.0;
};

// What waves add to the energy of all sound, and what arrivals of their gains times s add: a s^2 +
// 2 b s.
struct Energies {
  double waves = 0.0;
  double a = 0.0;
  double b = 0.0;
};

Energies sum_energies(const std::vector<Part>& parts, std::span<const Arrival> others, int band,
                      double speed_m_per_s) {
  Energies sum;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Part& part = parts[i];
    sum.waves += std::norm(part.pressure);
    sum.a += part.gain * part.gain;
    for (const Arrival& other : others) {
      const double later_m = part.distance_m - other.delay_s * speed_m_per_s;
      if (std::abs(later_m) > kApart_m) continue;
      const Complex turn =
          static_cast<double>(other.gain[band]) * mean_turn(band, later_m, speed_m_per_s);
      sum.waves += 2.0 * (part.pressure * turn).real();
      sum.b += part.gain * turn.real();
    }
    for (std::size_t j = 0; j < i; ++j) {
      const double later_m = part.distance_m - parts[j].distance_m;
      if (std::abs(later_m) > kApart_m) continue;
      const Complex turn = mean_turn(band, later_m, speed_m_per_s);
      sum.waves += 2.0 * (part.pressure * std::conj(parts[j].pressure) * turn).real();
      sum.a += 2.0 * part.gain * parts[j].gain * turn.real();
    }
  }
  return sum;
}

// The scale nearest to 1 that makes the energies equal, or as near as they come.
double matching_scale(const Energies& sum) {
  if (sum.a <= 0.0) return 1.0;
  const double middle = -sum.b / sum.a;
  const double reach = std::sqrt(std::max(0.0, middle * middle + sum.waves / sum.a));
  const double scale = middle < 1.0 ? middle + reach : middle - reach;
  return std::clamp(scale, -kLargestScale, kLargestScale);
}

}  // namespace

std::vector<BandArray> arrival_gains(std::span<const BentWave> waves,
                                     std::span<const Arrival> others, double speed_m_per_s) {
  std::vector<BandArray> gains;
  for (const BentWave& wave : waves) gains.push_back(band_gains(wave.spectrum));
  std::vector<Part> parts(waves.size());
  for (int band = 0; band < kOctaveBands; ++band) {
    for (std::size_t i = 0; i < waves.size(); ++i) {
      const BentWave& wave = waves[i];
      gains[i][band] *= wave.weight[band];
      const Complex centre =
          wave.spectrum[band * kFrequenciesPerBand + kFrequenciesPerBand / 2];
      const double gain = static_cast<double>(gains[i][band]);
      parts[i] = {wave.distance_m, std::polar(std::abs(gain), std::arg(centre)), gain};
    }
    const double scale = matching_scale(sum_energies(parts, others, band, speed_m_per_s));
    for (BandArray& gain : gains) gain[band] *= static_cast<float>(scale);
  }
  return gains;
}

}  // namespace earpoint
