#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/gtf/description.h>

namespace earpoint::gtf {

/// One frame of both ears, bin by bin: [ear][bin].
using EarSpectra = std::span<const std::complex<float>>;

/// What the network hears: features of each frame, and a summary of many.
class GtfSoundEncoder {
 public:
  explicit GtfSoundEncoder(const GtfDescription& description);

  /// Magnitudes of a frame. @param magnitude  [2][bins]
  static void measure(EarSpectra spectrum, std::span<float> magnitude);

  /// Features of a frame. Allocates nothing.
  /// @param magnitude  as measure() gave it
  /// @param features   [frame features]
  /// @param counts     for the summary, too
  void hear(EarSpectra spectrum, std::span<const float> magnitude, std::span<float> features,
            bool counts = true);

  /// How many frames count, after what faded.
  [[nodiscard]] double frames() const { return frames_; }

  /// Lets what was heard so far count less. @param share  that it keeps, 0 to 1
  void fade(float share);
  /// What was heard so far, in other units. @param factor  of its power
  void rescale(float factor);
  /// Forgets what was heard.
  void forget() { fade(0.0F); }

  /// @param summary  [summary features]. Allocates nothing.
  void summarize(std::span<float> summary) const;

 private:
  int bands_;
  std::vector<int> edges_;
  std::vector<float> lag_cosine_, lag_sine_;  // [lags][bins]
  double frames_ = 0.0;
  std::vector<float> power_;                // [2][bands], sums over frames
  std::vector<float> loudness_;             // [bands]
  std::vector<float> likeness_;             // [2: real, imaginary][bands], louder frames first
  std::vector<std::complex<float>> cross_;  // [bins]
  std::vector<float> strength_;             // [bins]
};

}  // namespace earpoint::gtf
