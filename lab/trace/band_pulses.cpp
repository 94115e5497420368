#include "band_pulses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

// Bands that share a later pulse. Low bands, with waves that are long against walls, have their
// own: a pulse a quarter of the centre's period later represents a band's phase best.
struct BandRange {
  int first = 0;
  int last = 0;
};
constexpr std::array<BandRange, 6> kShared = {{{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 5}, {6, 7}}};

// The mean over the band, scaled to the energy of the band. The gain is limited where parts of the
// band cancel, so that the phase does not jump.
std::complex<double> band_pressure(const DiffractionSpectrum& spectrum, int band) {
  constexpr double kMostGain = 2.0;
  std::complex<double> mean = 0.0;
  double energy = 0.0;
  for (int i = 0; i < kFrequenciesPerBand; ++i) {
    const std::complex<double>& part = spectrum[band * kFrequenciesPerBand + i];
    mean += part / static_cast<double>(kFrequenciesPerBand);
    energy += std::norm(part) / kFrequenciesPerBand;
  }
  if (energy <= 0.0) return 0.0;
  return mean * std::min(kMostGain, std::sqrt(energy) / std::max(1e-30, std::abs(mean)));
}

// The mean cosine of a lag over an octave with a flat spectrum. @param lag  at its centre, radians
double mean_cosine(double lag) {
  const double high = lag * std::sqrt(2.0);
  const double low = lag * std::sqrt(0.5);
  return (std::sin(high) - std::sin(low)) / (high - low);
}

}  // namespace

std::vector<BandPulse> band_pulses(const DiffractionSpectrum& spectrum) {
  std::vector<BandPulse> pulses(1);
  for (const auto& [first, last] : kShared) {
    const double middle_hz = std::sqrt(static_cast<double>(kOctaveBandCentresHz[first]) *
                                       static_cast<double>(kOctaveBandCentresHz[last]));
    BandPulse later{.later_s = 0.25 / middle_hz, .gain = {}};
    for (int band = first; band <= last; ++band) {
      // pressure = first gain + later gain * exp(-i lag)
      const std::complex<double> pressure = band_pressure(spectrum, band);
      const double lag = 2.0 * kPi * kOctaveBandCentresHz[band] * later.later_s;
      const double second = -pressure.imag() / std::sin(lag);
      const double first_gain = pressure.real() - second * std::cos(lag);
      // Away from the centre they add up differently; scaled to keep the energy over the octave.
      const double energy =
          first_gain * first_gain + second * second + 2.0 * first_gain * second * mean_cosine(lag);
      const double scale = energy > 0.0 ? std::sqrt(std::norm(pressure) / energy) : 0.0;
      later.gain[band] = static_cast<float>(scale * second);
      pulses[0].gain[band] = static_cast<float>(scale * first_gain);
    }
    pulses.push_back(later);
  }
  return pulses;
}

}  // namespace earpoint
