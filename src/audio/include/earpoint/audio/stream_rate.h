#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace earpoint {

/// Changes the sample rate of a live stream: a fixed, short delay and no allocation, where soxr
/// (StreamResampler) hands out its samples in bursts of several hundred. Linear phase: a Kaiser
/// window over 10 ms of a sinc. The pass band ends 0.5 kHz below the lower Nyquist frequency, what
/// lies 0.6 kHz and more above it is below -100 dB.
///
/// Cost: two multiplications per tap, 10 ms of the input's samples (or of the output's, where that
/// is the slower), for every sample that comes out.
class StreamRate {
 public:
  /// @param channels        > 0
  /// @param from_hz, to_hz  from 8000 to 384000, multiples of 50
  /// @param delay_s         half of the filter's length
  StreamRate(int channels, int from_hz, int to_hz, double delay_s = 0.005);

  /// @param in   planar, [channels][samples], samples * to / from a whole number
  /// @param out  planar, [channels][samples * to / from]; must not overlap `in`
  void process(std::span<const float> in, std::span<float> out);

  /// Sound comes out that much later than it went in; 0 between equal rates.
  [[nodiscard]] double delay_s() const { return delay_s_; }

  /// Back to silence.
  void reset();

 private:
  int channels_;
  int from_hz_;
  int to_hz_;
  double delay_s_ = 0.0;
  std::ptrdiff_t taps_ = 0;    // per phase
  std::ptrdiff_t phases_ = 0;  // of an output sample between two of the input
  std::ptrdiff_t step_ = 0;    // from output to output, in phases
  std::vector<float> kernel_;  // [phases][taps], oldest sample first
  std::vector<float> past_;    // [channels][taps - 1]
  std::vector<float> row_;     // one channel's past and block
};

}  // namespace earpoint
