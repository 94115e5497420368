#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace earpoint::plugin {

/// Delays two channels by a fixed number of samples. Allocates only when it is made.
class StereoDelay {
 public:
  /// @param samples  >= 0
  explicit StereoDelay(std::ptrdiff_t samples) {
    for (std::vector<float>& line : lines_) line.resize(static_cast<std::size_t>(samples));
  }

  /// @param in, out  [2][frames]; may be the same memory
  void process(const float* const* in, float* const* out, std::ptrdiff_t frames) {
    const std::size_t length = lines_[0].size();
    for (std::size_t c = 0; c < lines_.size(); ++c) {
      std::size_t at = at_;
      for (std::ptrdiff_t i = 0; i < frames; ++i) {
        const float sample = in[c][i];
        if (length == 0) {
          out[c][i] = sample;
          continue;
        }
        out[c][i] = lines_[c][at];
        lines_[c][at] = sample;
        at = at + 1 == length ? 0 : at + 1;
      }
    }
    if (length > 0) at_ = (at_ + static_cast<std::size_t>(frames)) % length;
  }

  void reset() {
    for (std::vector<float>& line : lines_) std::ranges::fill(line, 0.0F);
    at_ = 0;
  }

 private:
  std::array<std::vector<float>, 2> lines_;
  std::size_t at_ = 0;
};

}  // namespace earpoint::plugin
