#include <earpoint/spatial/octave_bands.h>

#include <algorithm>
#include <cmath>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

// Where a frequency lies between the lowest (0) and the highest centre (7), in octaves.
double octaves_above_lowest(double frequency_hz) {
  if (frequency_hz <= kOctaveBandCentresHz.front()) return 0.0;
  return std::min(std::log2(frequency_hz / kOctaveBandCentresHz.front()),
                  static_cast<double>(kOctaveBands - 1));
}

}  // namespace

double octave_band_weight(int band, double frequency_hz) {
  EARPOINT_CHECK(band >= 0 && band < kOctaveBands && frequency_hz >= 0.0);
  const double away = std::abs(octaves_above_lowest(frequency_hz) - band);
  if (away >= 1.0) return 0.0;
  const double amplitude = std::cos(kPi / 2.0 * away);
  return amplitude * amplitude;
}

int octave_bank_half_length(int sample_rate_hz) {
  EARPOINT_CHECK(sample_rate_hz > 0);
  // The lowest crossover, 62.5 to 125 Hz, rings longest.
  constexpr double kRinging_s = 0.032;
  return static_cast<int>(std::ceil(kRinging_s * sample_rate_hz));
}

OctaveBank::OctaveBank(int sample_rate_hz, int fft_size) : bins_(fft_size / 2 + 1) {
  EARPOINT_CHECK(sample_rate_hz > 0 && fft_size > 0 && fft_size % 2 == 0);
  weights_.resize(static_cast<std::size_t>(kOctaveBands) * bins_);
  lower_.resize(bins_);
  for (int bin = 0; bin < bins_; ++bin) {
    const double frequency_hz = static_cast<double>(sample_rate_hz) * bin / fft_size;
    for (int band = 0; band < kOctaveBands; ++band) {
      weights_[static_cast<std::size_t>(band) * bins_ + bin] =
          static_cast<float>(octave_band_weight(band, frequency_hz));
    }
    lower_[bin] = std::min(static_cast<int>(octaves_above_lowest(frequency_hz)), kOctaveBands - 2);
  }
}

std::span<const float> OctaveBank::weights(int band) const {
  EARPOINT_CHECK(band >= 0 && band < kOctaveBands);
  return std::span(weights_).subspan(static_cast<std::size_t>(band) * bins_, bins_);
}

void OctaveBank::gain_curve(const BandArray& gains, std::span<float> curve) const {
  EARPOINT_CHECK(std::ssize(curve) == bins_);
  for (int bin = 0; bin < bins_; ++bin) {
    const int band = lower_[bin];
    const float weight = weights_[static_cast<std::size_t>(band) * bins_ + bin];
    // The two weights sum to one, so equal gains come out exactly.
    curve[bin] = gains[band + 1] + weight * (gains[band] - gains[band + 1]);
  }
}

}  // namespace earpoint
