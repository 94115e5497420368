#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace earpoint {

/// Sound in memory: planar float32, [channels][samples], nominally within [-1, 1].
/// In a binaural waveform the left ear is channel 0.
class Waveform {
 public:
  Waveform() = default;
  /// Silence. @throws std::logic_error if channels < 0, samples < 0 or sample_rate_hz <= 0
  Waveform(int channels, std::ptrdiff_t samples, int sample_rate_hz);

  [[nodiscard]] int channels() const { return channels_; }
  [[nodiscard]] std::ptrdiff_t samples() const { return samples_; }
  [[nodiscard]] int sample_rate_hz() const { return sample_rate_hz_; }
  [[nodiscard]] double duration_s() const;
  [[nodiscard]] bool empty() const { return channels_ == 0 || samples_ == 0; }

  [[nodiscard]] std::span<float> channel(int index);
  [[nodiscard]] std::span<const float> channel(int index) const;

  /// All channels one after the other, shape [channels * samples].
  [[nodiscard]] std::span<float> planar() { return data_; }
  [[nodiscard]] std::span<const float> planar() const { return data_; }

 private:
  int channels_ = 0;
  std::ptrdiff_t samples_ = 0;
  int sample_rate_hz_ = 0;
  std::vector<float> data_;
};

}  // namespace earpoint
