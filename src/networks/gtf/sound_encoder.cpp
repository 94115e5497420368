#include "sound_encoder.h"

#include <cmath>

#include <earpoint/error.h>
#include <earpoint/gtf/constants.h>
#include <earpoint/pose.h>

namespace earpoint::gtf {
namespace {

using D = GtfDescription;

constexpr int kLagCount = 2 * D::kLags + 1;

void multiply_all(std::span<float> values, float factor) {
  for (float& value : values) value *= factor;
}

}  // namespace

GtfSoundEncoder::GtfSoundEncoder(const GtfDescription& description)
    : bands_(description.bands),
      edges_(gtf_band_edges(description.bands).value()),
      power_(static_cast<std::size_t>(2 * bands_)),
      loudness_(static_cast<std::size_t>(bands_)),
      likeness_(power_.size()),
      cross_(D::kBins),
      strength_(D::kBins) {
  for (int lag = -D::kLags; lag <= D::kLags; ++lag) {
    for (int bin = 0; bin < D::kBins; ++bin) {
      const double angle = 2.0 * kPi * lag * bin / D::kFftSize;
      lag_cosine_.push_back(static_cast<float>(std::cos(angle)));
      lag_sine_.push_back(static_cast<float>(std::sin(angle)));
    }
  }
}

void GtfSoundEncoder::measure(EarSpectra spectrum, std::span<float> magnitude) {
  EARPOINT_CHECK(spectrum.size() == magnitude.size());
  for (std::size_t i = 0; i < spectrum.size(); ++i) {
    const std::complex<float> x = spectrum[i];
    magnitude[i] = std::sqrt(x.real() * x.real() + x.imag() * x.imag() + gtf::kPowerFloor);
  }
}

void GtfSoundEncoder::hear(EarSpectra spectrum, std::span<const float> magnitude,
                           std::span<float> features, bool counts) {
  EARPOINT_CHECK(std::ssize(features) == std::ptrdiff_t{4} * bands_);
  const std::complex<float>* left = spectrum.data();
  const std::complex<float>* right = left + D::kBins;
  const float weight = counts ? 1.0F : 0.0F;
  frames_ += weight;
  for (int band = 0; band < bands_; ++band) {
    float power[2] = {};
    float common[2] = {};
    for (int bin = edges_[band]; bin < edges_[band + 1]; ++bin) {
      const float m0 = magnitude[bin];
      const float m1 = magnitude[D::kBins + bin];
      power[0] += m0 * m0;
      power[1] += m1 * m1;
      // left * conj(right)
      const float real =
          left[bin].real() * right[bin].real() + left[bin].imag() * right[bin].imag();
      const float imag =
          left[bin].imag() * right[bin].real() - left[bin].real() * right[bin].imag();
      common[0] += real;
      common[1] += imag;
      cross_[bin] += weight * std::complex<float>(real, imag);
      strength_[bin] += weight * std::sqrt(real * real + imag * imag);
    }
    const float scale = 1.0F / std::sqrt(power[0] * power[1] + gtf::kCrossFloor);
    const float loudness = power[0] + power[1];
    loudness_[band] += weight * loudness;
    for (int i = 0; i < 2; ++i) {
      features[i * bands_ + band] = std::log(power[i] + gtf::kBandFloor) / gtf::kBandLogScale;
      features[(2 + i) * bands_ + band] = common[i] * scale;
      power_[i * bands_ + band] += weight * power[i];
      likeness_[i * bands_ + band] += weight * loudness * common[i] * scale;
    }
  }
}

void GtfSoundEncoder::fade(float share) {
  frames_ *= share;
  rescale(share);
}

void GtfSoundEncoder::rescale(float factor) {
  multiply_all(power_, factor);
  multiply_all(loudness_, factor);
  multiply_all(likeness_, factor);
  multiply_all(strength_, factor);
  for (std::complex<float>& value : cross_) value *= factor;
}

void GtfSoundEncoder::summarize(std::span<float> summary) const {
  EARPOINT_CHECK(std::ssize(summary) == 4 * bands_ + kLagCount);
  const auto frames = static_cast<float>(frames_ > 0.0 ? frames_ : 1.0);
  for (int band = 0; band < bands_; ++band) {
    const float loudness = 1.0F / (loudness_[band] + gtf::kStrengthFloor);
    summary[band] = likeness_[band] * loudness;
    summary[bands_ + band] = likeness_[bands_ + band] * loudness;
    const float left = power_[band] / frames;
    const float right = power_[bands_ + band] / frames;
    summary[2 * bands_ + band] =
        std::log((left + gtf::kBalanceFloor) / (right + gtf::kBalanceFloor)) / 2;
    summary[3 * bands_ + band] = std::log(left + right + gtf::kBandFloor) / gtf::kBandLogScale;
  }
  for (int lag = 0; lag < kLagCount; ++lag) {
    const float* cosine = lag_cosine_.data() + std::ptrdiff_t{lag} * D::kBins;
    const float* sine = lag_sine_.data() + std::ptrdiff_t{lag} * D::kBins;
    float sum = 0.0F;
    for (int bin = 0; bin < D::kBins; ++bin) {
      const float weight = 1.0F / (strength_[bin] + gtf::kStrengthFloor);
      sum += weight * (cross_[bin].real() * cosine[bin] - cross_[bin].imag() * sine[bin]);
    }
    summary[4 * bands_ + lag] = sum / gtf::kLagScale;
  }
}

}  // namespace earpoint::gtf
