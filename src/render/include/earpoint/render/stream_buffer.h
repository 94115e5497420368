#pragma once

#include <cstddef>
#include <vector>

#include <earpoint/waveform.h>

namespace earpoint {

/// A stretch of a stream, addressed by the sample's number since the stream's start: append at one
/// end, drop at the other, read any window in between.
class StreamBuffer {
 public:
  StreamBuffer(int channels, int sample_rate_hz);

  void append(const Waveform& block);

  /// Forgets everything before sample `start`.
  void drop_before(std::ptrdiff_t start);

  /// @return [channels][count] from sample `start`; zeros before the stream's start and after its
  ///         present end
  /// @throws std::logic_error if part of it has been dropped
  [[nodiscard]] Waveform copy(std::ptrdiff_t start, std::ptrdiff_t count) const;

  /// One past the last sample appended.
  [[nodiscard]] std::ptrdiff_t end() const { return begin_ + held(); }
  [[nodiscard]] std::ptrdiff_t begin() const { return begin_; }

 private:
  [[nodiscard]] std::ptrdiff_t held() const {
    return static_cast<std::ptrdiff_t>(channels_.front().size());
  }

  int sample_rate_hz_;
  std::ptrdiff_t begin_ = 0;
  std::vector<std::vector<float>> channels_;
};

}  // namespace earpoint
