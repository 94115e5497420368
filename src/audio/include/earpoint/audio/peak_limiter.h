#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/waveform.h>

namespace earpoint {

/// Keeps a stream of sound within full scale. One gain for all channels, so that the level between
/// the ears stays; it falls over 5 ms before a peak and returns within about 100 ms. Sound that
/// stays within full scale passes unchanged, sample by sample.
///
/// Memory: 5 ms of sound. Cost: O(samples).
class PeakLimiter {
 public:
  PeakLimiter(int channels, int sample_rate_hz);

  /// @param block  [channels][any number of samples], finite
  /// @param last   whether nothing follows: what is held back is returned too
  /// @return  [channels][samples], the stream so far but for the last 5 ms
  [[nodiscard]] Waveform process(const Waveform& block, bool last);

  /// The same for a live stream: limits a block in place, late by latency_samples(). Allocates
  /// nothing. A stream is processed by the one or the other.
  /// @param block  planar, [channels][any number of samples], finite
  void process_late(std::span<float> block);
  [[nodiscard]] std::ptrdiff_t latency_samples() const { return ahead_; }

  /// Back to silence.
  void reset();

  /// By how much the strongest peak so far exceeded full scale, in decibels; 0 if none did.
  [[nodiscard]] double excess_db() const;

 private:
  /// A gain that a sample wants, and when.
  struct Wish {
    std::ptrdiff_t position = 0;
    float gain = 1.0F;
  };
  float next_gain(float peak);

  int channels_;
  int sample_rate_hz_;
  std::ptrdiff_t ahead_;      // samples
  double release_;            // share of a reduction that is left from sample to sample
  std::vector<float> held_;   // [channels][ahead_], a ring
  std::vector<Wish> minima_;  // of the gains wanted ahead, growing; a ring of ahead_ + 1
  std::size_t first_ = 0;     // of minima_
  std::size_t minima_held_ = 0;
  std::vector<double> reductions_;  // the last ahead_ + 1, a ring
  double reduction_ = 0.0;          // 1 - gain, falling slowly
  double sum_ = 0.0;                // of reductions_
  std::ptrdiff_t position_ = 0;
  float peak_ = 0.0F;
};

}  // namespace earpoint
