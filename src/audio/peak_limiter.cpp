#include <algorithm>
#include <cmath>

#include <earpoint/audio/peak_limiter.h>
#include <earpoint/core/error.h>

namespace earpoint {
namespace {

constexpr double kAhead_s = 0.005;
constexpr double kRelease_s = 0.05;  // time constant

}  // namespace

PeakLimiter::PeakLimiter(int channels, int sample_rate_hz)
    : channels_(channels),
      sample_rate_hz_(sample_rate_hz),
      ahead_(static_cast<std::ptrdiff_t>(kAhead_s * sample_rate_hz)),
      release_(std::exp(-1.0 / (kRelease_s * sample_rate_hz))),
      held_(channels, ahead_, sample_rate_hz),
      reductions_(static_cast<std::size_t>(ahead_) + 1) {
  EARPOINT_CHECK(channels > 0 && ahead_ > 0);
}

double PeakLimiter::excess_db() const {
  return peak_ > 1.0F ? 20.0 * std::log10(double{peak_}) : 0.0;
}

/// Takes the peak of the newest sample and gives the gain of the one that lies ahead_ behind it:
/// the mean, over the ahead_ samples before it, of the least gain that any of the ahead_ samples
/// after each wants. Every value in that mean is at most what the sample itself wants.
float PeakLimiter::next_gain(float peak) {
  peak_ = std::max(peak_, peak);
  const float wanted = peak > 1.0F ? 1.0F / peak : 1.0F;
  while (!minima_.empty() && minima_.back().second >= wanted) minima_.pop_back();
  minima_.emplace_back(position_, wanted);
  if (minima_.front().first < position_ - ahead_) minima_.pop_front();
  reduction_ = std::max(1.0 - double{minima_.front().second}, reduction_ * release_);
  // What is inaudible ends, or a stream would never pass unchanged again.
  if (reduction_ < 1e-5) reduction_ = 0.0;

  double& oldest = reductions_[static_cast<std::size_t>(position_ % (ahead_ + 1))];
  sum_ += reduction_ - oldest;
  oldest = reduction_;
  ++position_;
  const double mean = sum_ / static_cast<double>(ahead_ + 1);
  return static_cast<float>(1.0 - mean);
}

Waveform PeakLimiter::process(const Waveform& block, bool last) {
  EARPOINT_CHECK(block.channels() == channels_);
  const std::ptrdiff_t held = position_ == 0 ? 0 : std::min(position_, ahead_);
  const std::ptrdiff_t total = held + block.samples();
  const std::ptrdiff_t out = last ? total : std::max<std::ptrdiff_t>(0, total - ahead_);
  Waveform whole(channels_, total, sample_rate_hz_);
  for (int c = 0; c < channels_; ++c) {
    std::copy_n(held_.channel(c).begin(), held, whole.channel(c).begin());
    std::ranges::copy(block.channel(c), whole.channel(c).begin() + held);
  }

  Waveform result(channels_, out, sample_rate_hz_);
  const std::ptrdiff_t steps = block.samples() + (last ? ahead_ : 0);
  for (std::ptrdiff_t i = 0; i < steps; ++i) {
    float peak = 0.0F;
    for (int c = 0; c < channels_ && i < block.samples(); ++c) {
      peak = std::max(peak, std::abs(block.channel(c)[i]));
    }
    const float gain = next_gain(peak);
    const std::ptrdiff_t at = held + i - ahead_;
    if (at < 0 || at >= out) continue;
    for (int c = 0; c < channels_; ++c) {
      // The gain's rounding may leave a bit beyond full scale.
      result.channel(c)[at] = gain == 1.0F ? whole.channel(c)[at]
                                           : std::clamp(whole.channel(c)[at] * gain, -1.0F, 1.0F);
    }
  }
  held_ = Waveform(channels_, ahead_, sample_rate_hz_);
  for (int c = 0; c < channels_; ++c) {
    std::copy_n(whole.channel(c).begin() + out, total - out, held_.channel(c).begin());
  }
  return result;
}

}  // namespace earpoint
