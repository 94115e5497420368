#include "pulse_train.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr int kFiner = 2;  // grid points per sample
constexpr int kWidth = 8;  // grid points that a pulse is spread over
constexpr double kShape = 2.3 * kWidth;

// The spreading function, on [-1, 1]: nearly optimally concentrated, and cheap.
double spread(double place) {
  const double inside = 1.0 - place * place;
  return inside <= 0.0 ? 0.0 : std::exp(kShape * (std::sqrt(inside) - 1.0));
}

// One over its Fourier transform. The integrand and its derivatives vanish at both ends to a
// float's precision, so that the trapezoidal rule is exact.
double correction(double radians_per_point) {
  constexpr int kSteps = 48;
  double sum = 0.0;
  for (int i = -kSteps + 1; i < kSteps; ++i) {
    const double place = static_cast<double>(i) / kSteps;
    sum += spread(place) * std::cos(radians_per_point * place * (kWidth / 2.0));
  }
  return 1.0 / (sum * (kWidth / 2.0) / kSteps);
}

}  // namespace

PulseTrain::PulseTrain(int fft_size) : fft_(kFiner * fft_size), spectrum_(fft_.bins()) {
  EARPOINT_CHECK(fft_size % 2 == 0 && fft_size >= kWidth);
  for (std::vector<float>& grid : grids_) grid.resize(fft_.size());
  for (int bin = 0; bin <= fft_size / 2; ++bin) {
    correction_.push_back(static_cast<float>(correction(2.0 * kPi * bin / fft_.size())));
  }
}

void PulseTrain::clear() {
  for (std::vector<float>& grid : grids_) std::fill(grid.begin(), grid.end(), 0.0F);
}

void PulseTrain::add(double position_samples, const BandArray& gains) {
  const double position = kFiner * position_samples;
  const auto size = static_cast<std::ptrdiff_t>(fft_.size());
  const auto first = static_cast<std::ptrdiff_t>(std::ceil(position - kWidth / 2.0));
  for (std::ptrdiff_t i = 0; i < kWidth; ++i) {
    const auto share =
        static_cast<float>(spread((static_cast<double>(first + i) - position) / (kWidth / 2.0)));
    const std::ptrdiff_t point = ((first + i) % size + size) % size;
    for (int band = 0; band < kOctaveBands; ++band) grids_[band][point] += share * gains[band];
  }
}

void PulseTrain::add_spectrum(const OctaveBank& bank, std::span<std::complex<float>> sum) {
  EARPOINT_CHECK(sum.size() == correction_.size() && std::ssize(sum) == bank.bins());
  for (int band = 0; band < kOctaveBands; ++band) {
    fft_.forward(grids_[band], spectrum_);
    const std::span<const float> weights = bank.weights(band);
    for (std::size_t bin = 0; bin < sum.size(); ++bin) {
      sum[bin] += spectrum_[bin] * (weights[bin] * correction_[bin]);
    }
  }
}

}  // namespace earpoint
