#pragma once

#include <cstddef>
#include <deque>
#include <utility>
#include <vector>

#include <earpoint/core/waveform.h>

namespace earpoint {

/// Keeps a stream of sound within full scale. One gain for all channels, so that the level between
/// the ears stays; it falls over 5 ms before a peak and returns within about 100 ms. Sound that
/// stays within full scale passes unchanged, sample by sample.
///
/// Memory: 5 ms of sound. Cost: O(samples); allocates, so not for the audio thread.
class PeakLimiter {
 public:
  PeakLimiter(int channels, int sample_rate_hz);

  /// @param block  [channels][any number of samples], finite
  /// @param last   whether nothing follows: what is held back is returned too
  /// @return  [channels][samples], the stream so far but for the last 5 ms
  [[nodiscard]] Waveform process(const Waveform& block, bool last);

  /// By how much the strongest peak so far exceeded full scale, in decibels; 0 if none did.
  [[nodiscard]] double excess_db() const;

 private:
  float next_gain(float peak);

  int channels_;
  int sample_rate_hz_;
  std::ptrdiff_t ahead_;  // samples
  double release_;        // share of a reduction that is left from sample to sample
  Waveform held_;
  std::deque<std::pair<std::ptrdiff_t, float>> minima_;  // of the gains wanted ahead, growing
  std::vector<double> reductions_;                       // the last ahead_ + 1, a ring
  double reduction_ = 0.0;                               // 1 - gain, falling slowly
  double sum_ = 0.0;                                     // of reductions_
  std::ptrdiff_t position_ = 0;
  float peak_ = 0.0F;
};

}  // namespace earpoint
