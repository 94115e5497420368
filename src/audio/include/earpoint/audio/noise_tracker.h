#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace earpoint {

/// Tracks the power spectrum of noise under speech by minima-controlled recursive averaging: where
/// the smoothed power is within 7 dB of its minimum over about a second, the frame is taken as
/// noise and averaged in.
///
/// Falling noise is followed within 0.3 s. Noise that rises by more than 7 dB looks like speech
/// until the minima of before are forgotten: it is followed within 1.6 s.
/// Source: Cohen and Berdugo, IEEE Signal Processing Letters 9 (2002), with minima over eight
/// shorter windows as Martin, IEEE Trans. SAP 9 (2001). The probability of speech rises to one at
/// once, and not over some frames, so that the first frame of a syllable is no noise.
class NoiseTracker {
 public:
  /// @param bins   of the power spectra
  /// @param hop_s  seconds from one frame to the next
  NoiseTracker(int bins, double hop_s);

  /// Estimates the noise at the beginning of a stream.
  /// @param frames  power spectra of its first frames, row-major [frames][bins], at least one
  void start(std::span<const float> frames);

  /// @param power  [bins], power spectrum of the next frame; after start()
  void update(std::span<const float> power);

  /// Mean power of the noise, [bins].
  [[nodiscard]] std::span<const float> noise() const { return noise_; }

 private:
  void smooth(std::span<const float> power, bool first);

  int window_frames_;  // of one of the shorter windows
  double smoothing_;
  double averaging_;
  double presence_smoothing_;
  int frame_ = 0;
  std::size_t next_window_ = 0;
  std::vector<float> smoothed_;
  std::vector<float> minimum_;  // over all windows and the present one
  std::vector<float> present_;  // minimum of the present window
  std::vector<std::vector<float>> windows_;
  std::vector<float> presence_;
  std::vector<float> noise_;
};

}  // namespace earpoint
