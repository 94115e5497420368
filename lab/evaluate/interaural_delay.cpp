#include "interaural_delay.h"

#include <algorithm>
#include <cmath>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kLongest_s = 1e-3;
constexpr int kFiner = 4;
constexpr float kFloor = 1e-6F;  // -60 dB of power
// A cut of the sound is an edge at the same time in both ears, which would count as a delay of zero
// in all bins with little other energy.
constexpr double kFade_s = 0.01;

bool is_silent(std::span<const float> ear) {
  return std::ranges::all_of(ear, [](float x) { return x == 0.0F; });
}

}  // namespace

void InterauralDelay::transform(std::span<const float> ear,
                                std::vector<std::complex<float>>& spectrum) {
  std::ranges::fill(padded_, 0.0F);
  std::ranges::copy(ear, padded_.begin());
  const std::size_t fade = std::min(fade_.size(), ear.size() / 2);
  for (std::size_t i = 0; i < fade; ++i) {
    padded_[i] *= fade_[i];
    padded_[ear.size() - 1 - i] *= fade_[i];
  }
  fft_->forward(padded_, spectrum);
}

void InterauralDelay::plan(int size, int sample_rate_hz) {
  fade_.resize(static_cast<std::size_t>(std::lround(kFade_s * sample_rate_hz)));
  for (std::size_t i = 0; i < fade_.size(); ++i) {
    const double phase_rad =
        kPi * (static_cast<double>(i) + 0.5) / static_cast<double>(fade_.size());
    fade_[i] = static_cast<float>(0.5 - 0.5 * std::cos(phase_rad));
  }
  if (fft_ && fft_->size() == size) return;
  fft_.emplace(size);
  fine_fft_.emplace(kFiner * size);
  left_.resize(static_cast<std::size_t>(fft_->bins()));
  right_.resize(left_.size());
  cross_.assign(static_cast<std::size_t>(fine_fft_->bins()), {});
  padded_.resize(static_cast<std::size_t>(size));
  correlation_.resize(static_cast<std::size_t>(fine_fft_->size()));
}

std::optional<double> InterauralDelay::measure_s(const Waveform& binaural) {
  EARPOINT_CHECK(binaural.channels() == 2 && binaural.samples() > 0);
  if (is_silent(binaural.channel(0)) || is_silent(binaural.channel(1))) return std::nullopt;
  const int reach = static_cast<int>(std::ceil(kFiner * kLongest_s * binaural.sample_rate_hz()));
  // Lags up to 1 ms must not wrap around.
  plan(fast_fft_size(static_cast<int>(binaural.samples()) + reach / kFiner + 1),
       binaural.sample_rate_hz());
  transform(binaural.channel(0), left_);
  transform(binaural.channel(1), right_);
  double sum = 0.0;
  for (std::size_t k = 0; k < right_.size(); ++k) {
    const std::complex<float> a = right_[k];
    const std::complex<float> b = left_[k];
    cross_[k] = {a.real() * b.real() + a.imag() * b.imag(),
                 a.imag() * b.real() - a.real() * b.imag()};
    sum += std::abs(cross_[k]);
  }
  const float floor = kFloor * static_cast<float>(sum / static_cast<double>(right_.size()));
  if (floor == 0.0F) return std::nullopt;
  for (std::size_t k = 0; k < right_.size(); ++k) cross_[k] /= std::abs(cross_[k]) + floor;
  fine_fft_->inverse(cross_, correlation_);

  const auto at = [&](int lag) {
    const int place = lag < 0 ? lag + fine_fft_->size() : lag;
    return double{correlation_[static_cast<std::size_t>(place)]};
  };
  int best = -reach;
  for (int lag = -reach; lag <= reach; ++lag) {
    if (at(lag) > at(best)) best = lag;
  }
  double place = best;
  // A maximum at the edge of the search range has no peak to interpolate.
  if (best > -reach && best < reach) {
    const double curvature = at(best - 1) - 2.0 * at(best) + at(best + 1);
    if (curvature < 0.0) place += 0.5 * (at(best - 1) - at(best + 1)) / curvature;
  }
  return place / (kFiner * binaural.sample_rate_hz());
}

}  // namespace earpoint
