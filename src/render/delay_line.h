#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace earpoint {

/// Holds planar sound back by a fixed number of samples.
class DelayLine {
 public:
  DelayLine(int channels, std::ptrdiff_t delay)
      : channels_(channels), delay_(delay), held_(static_cast<std::size_t>(channels * delay)) {}

  /// @param block  planar, [channels][samples], delayed in place
  void process(std::span<float> block) {
    if (delay_ == 0) return;
    const std::ptrdiff_t samples = std::ssize(block) / channels_;
    for (int c = 0; c < channels_; ++c) {
      float* const channel = block.data() + c * samples;
      float* const held = held_.data() + c * delay_;
      for (std::ptrdiff_t i = 0, at = position_; i < samples; ++i) {
        channel[i] = std::exchange(held[at], channel[i]);
        if (++at == delay_) at = 0;
      }
    }
    position_ = (position_ + samples) % delay_;
  }

  void reset() { std::ranges::fill(held_, 0.0F); }

 private:
  int channels_;
  std::ptrdiff_t delay_;
  std::vector<float> held_;  // [channels][delay], a ring
  std::ptrdiff_t position_ = 0;
};

}  // namespace earpoint
