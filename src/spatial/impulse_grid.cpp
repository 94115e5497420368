#include "impulse_grid.h"

#include <algorithm>
#include <cmath>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr int kWidth = 8;    // grid points under the kernel
constexpr int kFine = 4096;  // kernel samples per grid point
constexpr int kOversampling = 2;

double shape() {
  const double reach = static_cast<double>(kWidth) / kOversampling * (kOversampling - 0.5);
  return kPi * std::sqrt(reach * reach - 0.8);
}

// The kernel at a distance in grid points.
double kernel(double distance) {
  const double x = 2.0 * distance / kWidth;
  return x >= 1.0 ? 0.0 : std::cyl_bessel_i(0.0, shape() * std::sqrt(1.0 - x * x));
}

// Its Fourier transform, at cycles per grid point.
double kernel_spectrum(double frequency) {
  const double phase = kPi * kWidth * frequency;
  const double root = std::sqrt(shape() * shape() - phase * phase);
  return kWidth * std::sinh(root) / root;
}

}  // namespace

ImpulseGrid::ImpulseGrid(int sample_rate_hz, int size)
    : bank_(sample_rate_hz, size), fft_(kOversampling * size), work_(fft_.bins()) {
  for (int i = 0; i <= kWidth / 2 * kFine + 1; ++i) {
    kernel_.push_back(
        static_cast<float>(kernel(static_cast<double>(i) / kFine) / kernel_spectrum(0.0)));
  }
  for (int bin = 0; bin < bank_.bins(); ++bin) {
    correction_.push_back(static_cast<float>(
        kernel_spectrum(0.0) / kernel_spectrum(static_cast<double>(bin) / fft_.size())));
  }
  for (auto& band : grid_) band.assign(fft_.size(), 0.0F);
}

void ImpulseGrid::add(double time_samples, const BandArray& gain) {
  const double point = kOversampling * time_samples;
  const int first = static_cast<int>(std::ceil(point - kWidth / 2.0));
  EARPOINT_DCHECK(first >= 0 && first + kWidth <= fft_.size());
  std::array<float, kWidth> spread{};
  for (int i = 0; i < kWidth; ++i) {
    const double at = std::abs(first + i - point) * kFine;
    const auto below = static_cast<std::size_t>(at);
    const auto between = static_cast<float>(at - static_cast<double>(below));
    spread[i] = kernel_[below] + between * (kernel_[below + 1] - kernel_[below]);
  }
  for (int band = 0; band < kOctaveBands; ++band) {
    float* points = grid_[band].data() + first;
    for (int i = 0; i < kWidth; ++i) points[i] += gain[band] * spread[i];
  }
}

void ImpulseGrid::take(std::span<std::complex<float>> spectrum) {
  EARPOINT_CHECK(std::ssize(spectrum) == bins());
  std::ranges::fill(spectrum, 0.0F);
  for (int band = 0; band < kOctaveBands; ++band) {
    fft_.forward(grid_[band], work_);
    std::ranges::fill(grid_[band], 0.0F);
    const std::span<const float> weights = bank_.weights(band);
    for (int bin = 0; bin < bins(); ++bin) {
      spectrum[bin] += weights[bin] * correction_[bin] * work_[bin];
    }
  }
}

}  // namespace earpoint
