#include <earpoint/audio/peak_limiter.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <earpoint/error.h>

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
      held_(static_cast<std::size_t>(channels * ahead_)),
      minima_(static_cast<std::size_t>(ahead_) + 1),
      reductions_(static_cast<std::size_t>(ahead_) + 1) {
  EARPOINT_CHECK(channels > 0 && ahead_ > 0);
}

void PeakLimiter::reset() {
  std::ranges::fill(held_, 0.0F);
  std::ranges::fill(reductions_, 0.0);
  first_ = minima_held_ = 0;
  reduction_ = sum_ = 0.0;
  position_ = 0;
  peak_ = 0.0F;
}

double PeakLimiter::excess_db() const {
  return peak_ > 1.0F ? 20.0 * std::log10(double{peak_}) : 0.0;
}

/// Takes the peak of the newest sample and returns the gain of the sample ahead_ before it: the
/// mean of the last ahead_ + 1 values of the smallest gain wanted within ahead_ + 1 samples, with
/// release. Each of these values covers the sample, so the mean is at most the gain that it needs.
float PeakLimiter::next_gain(float peak) {
  peak_ = std::max(peak_, peak);
  const float wanted = peak > 1.0F ? 1.0F / peak : 1.0F;
  const auto minimum = [this](std::size_t index) -> Wish& {
    return minima_[(first_ + index) % minima_.size()];
  };
  if (minima_held_ > 0 && minimum(0).position < position_ - ahead_) {
    first_ = (first_ + 1) % minima_.size();
    --minima_held_;
  }
  while (minima_held_ > 0 && minimum(minima_held_ - 1).gain >= wanted) --minima_held_;
  minimum(minima_held_) = {position_, wanted};
  ++minima_held_;
  reduction_ = std::max(1.0 - double{minimum(0).gain}, reduction_ * release_);
  // Ends an inaudible reduction; otherwise a stream would never pass unchanged again.
  if (reduction_ < 1e-5) reduction_ = 0.0;

  double& oldest = reductions_[static_cast<std::size_t>(position_ % (ahead_ + 1))];
  sum_ += reduction_ - oldest;
  oldest = reduction_;
  ++position_;
  const double mean = sum_ / static_cast<double>(ahead_ + 1);
  return static_cast<float>(1.0 - mean);
}

void PeakLimiter::process_late(std::span<float> block) {
  const auto samples = static_cast<std::ptrdiff_t>(block.size()) / channels_;
  EARPOINT_CHECK(samples * channels_ == std::ssize(block));
  for (std::ptrdiff_t i = 0; i < samples; ++i) {
    const std::ptrdiff_t slot = position_ % ahead_;
    float peak = 0.0F;
    for (int c = 0; c < channels_; ++c) peak = std::max(peak, std::abs(block[c * samples + i]));
    const float gain = next_gain(peak);
    for (int c = 0; c < channels_; ++c) {
      float& held = held_[static_cast<std::size_t>(c * ahead_ + slot)];
      const float sample = std::exchange(held, block[c * samples + i]);
      // The gain's rounding may leave a bit beyond full scale.
      block[c * samples + i] = gain == 1.0F ? sample : std::clamp(sample * gain, -1.0F, 1.0F);
    }
  }
}

Waveform PeakLimiter::process(const Waveform& block, bool last) {
  EARPOINT_CHECK(block.channels() == channels_);
  const std::ptrdiff_t before = position_;
  const std::ptrdiff_t total = block.samples() + (last ? ahead_ : 0);
  Waveform late(channels_, total, sample_rate_hz_);
  for (int c = 0; c < channels_; ++c) std::ranges::copy(block.channel(c), late.channel(c).begin());
  process_late(late.planar());
  // The first ahead_ samples that come out are silence before the stream.
  const std::ptrdiff_t dropped = std::clamp<std::ptrdiff_t>(ahead_ - before, 0, total);
  Waveform result(channels_, total - dropped, sample_rate_hz_);
  for (int c = 0; c < channels_; ++c) {
    std::ranges::copy(late.channel(c).subspan(static_cast<std::size_t>(dropped)),
                      result.channel(c).begin());
  }
  return result;
}

}  // namespace earpoint
