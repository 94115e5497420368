#include "delay_finder.h"

#include <algorithm>
#include <cmath>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kLowest_hz = 200.0;
constexpr double kHighest_hz = 7000.0;
constexpr float kLeastShare = 0.01F;  ///< of the mean power in the band, for a bin to count
constexpr double kLeastHeight = 0.3;  ///< of a candidate, re the highest
constexpr std::size_t kMostCandidates = 6;

}  // namespace

DelayFinder::DelayFinder(int template_samples, int search_samples, int sample_rate_hz)
    : search_samples_(search_samples),
      fft_(fast_fft_size(template_samples + search_samples)),
      window_(static_cast<std::size_t>(template_samples)),
      signal_(static_cast<std::size_t>(fft_.size())),
      template_(static_cast<std::size_t>(fft_.bins())),
      weight_(template_.size()),
      spectrum_(template_.size()) {
  const double bins_per_hz = static_cast<double>(fft_.size()) / sample_rate_hz;
  first_bin_ = static_cast<std::size_t>(kLowest_hz * bins_per_hz);
  last_bin_ = std::min(template_.size() - 1, static_cast<std::size_t>(kHighest_hz * bins_per_hz));
  for (std::size_t i = 0; i < window_.size(); ++i) {
    const double turn = 2.0 * kPi * (static_cast<double>(i) + 0.5) / template_samples;
    window_[i] = static_cast<float>(0.5 - 0.5 * std::cos(turn));
  }
}

void DelayFinder::set_template(std::span<const float> sound) {
  EARPOINT_CHECK(sound.size() == window_.size());
  std::ranges::fill(signal_, 0.0F);
  for (std::size_t i = 0; i < sound.size(); ++i) signal_[i] = sound[i] * window_[i];
  fft_.forward(signal_, template_);
  float mean = 0.0F;
  for (std::size_t k = first_bin_; k <= last_bin_; ++k) mean += std::norm(template_[k]);
  mean /= static_cast<float>(last_bin_ - first_bin_ + 1);
  std::ranges::fill(weight_, 0.0F);
  for (std::size_t k = first_bin_; k <= last_bin_; ++k) {
    if (std::norm(template_[k]) > kLeastShare * mean) weight_[k] = 1.0F;
  }
}

std::vector<DelayCandidate> DelayFinder::find(std::span<const float> sound) {
  EARPOINT_CHECK(sound.size() == window_.size() + static_cast<std::size_t>(search_samples_));
  std::ranges::fill(signal_, 0.0F);
  std::ranges::copy(sound, signal_.begin());
  fft_.forward(signal_, spectrum_);
  for (std::size_t k = 0; k < spectrum_.size(); ++k) {
    if (weight_[k] == 0.0F) {
      spectrum_[k] = 0.0F;
      continue;
    }
    const std::complex<float> a = spectrum_[k];
    const std::complex<float> b = template_[k];
    const std::complex<float> cross{a.real() * b.real() + a.imag() * b.imag(),
                                    a.imag() * b.real() - a.real() * b.imag()};
    const float magnitude = std::abs(cross);
    spectrum_[k] = magnitude > 0.0F ? cross / magnitude : 0.0F;
  }
  fft_.inverse(spectrum_, signal_);

  std::vector<DelayCandidate> peaks;
  for (int lag = 1; lag < search_samples_; ++lag) {
    const double here = signal_[lag];
    const double before = signal_[lag - 1];
    const double after = signal_[lag + 1];
    if (here <= 0.0 || here < before || here <= after) continue;
    // The vertex of the parabola through the three.
    const double curvature = before - 2.0 * here + after;
    const double shift = curvature < 0.0 ? 0.5 * (before - after) / curvature : 0.0;
    peaks.push_back({lag + shift, here - 0.25 * (before - after) * shift});
  }
  const std::size_t kept = std::min(kMostCandidates, peaks.size());
  std::partial_sort(peaks.begin(), peaks.begin() + static_cast<std::ptrdiff_t>(kept), peaks.end(),
                    [](const auto& a, const auto& b) { return a.height > b.height; });
  peaks.resize(kept);
  if (peaks.empty()) return peaks;
  const double highest = peaks.front().height;
  for (DelayCandidate& peak : peaks) peak.height /= highest;
  std::erase_if(peaks, [](const DelayCandidate& peak) { return peak.height < kLeastHeight; });
  return peaks;
}

}  // namespace earpoint
