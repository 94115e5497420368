#include <earpoint/render/overlap_adder.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

/// Correlation coefficient without removing the mean, clamped to [0, 1]: opposed windows would ask
/// for an unbounded gain, so they fade like unrelated ones. Silence counts as equal.
double correlation(std::span<const float> a, std::span<const float> b) {
  double ab = 0.0;
  double aa = 0.0;
  double bb = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += static_cast<double>(a[i]) * b[i];
    aa += static_cast<double>(a[i]) * a[i];
    bb += static_cast<double>(b[i]) * b[i];
  }
  if (aa <= 0.0 || bb <= 0.0) return 1.0;
  return std::clamp(ab / std::sqrt(aa * bb), 0.0, 1.0);
}

}  // namespace

OverlapAdder::OverlapAdder(std::ptrdiff_t window, std::ptrdiff_t overlap)
    : window_(window), overlap_(overlap) {
  EARPOINT_CHECK(window > 0 && overlap >= 0 && 2 * overlap <= window);
  for (std::ptrdiff_t i = 0; i < overlap; ++i) {
    const double sine =
        std::sin(kPi / 2 * (static_cast<double>(i) + 0.5) / static_cast<double>(overlap));
    rising_.push_back(sine * sine);
  }
}

Waveform OverlapAdder::add(const Waveform& window) {
  EARPOINT_CHECK(window.samples() == window_);
  const std::ptrdiff_t hop = window_ - overlap_;
  Waveform done(window.channels(), hop, window.sample_rate_hz());
  Waveform next_tail(window.channels(), overlap_, window.sample_rate_hz());
  for (int c = 0; c < window.channels(); ++c) {
    const std::span<const float> samples = window.channel(c);
    std::copy_n(samples.begin(), hop, done.channel(c).begin());
    std::copy_n(samples.begin() + hop, overlap_, next_tail.channel(c).begin());
    if (tail_.empty()) continue;

    const std::span<const float> old = std::as_const(tail_).channel(c);
    const double rho = correlation(old, samples.first(old.size()));
    for (std::ptrdiff_t i = 0; i < overlap_; ++i) {
      const double rising = rising_[i];
      const double falling = 1.0 - rising;
      const double gain =
          1.0 / std::sqrt(falling * falling + rising * rising + 2.0 * rho * falling * rising);
      done.channel(c)[i] = static_cast<float>(gain * (falling * old[i] + rising * samples[i]));
    }
  }
  tail_ = std::move(next_tail);
  return done;
}

Waveform OverlapAdder::flush() { return std::exchange(tail_, Waveform()); }

}  // namespace earpoint
