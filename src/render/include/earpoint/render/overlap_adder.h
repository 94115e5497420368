#pragma once

#include <cstddef>
#include <vector>

#include <earpoint/waveform.h>

namespace earpoint {

/// Joins overlapping windows into one stream with a cross-fade of constant power.
///
/// Neighbouring windows render the same moment, so what they say about it is anything from equal
/// (fading by amplitude keeps the power) to unrelated (fading by the square root of power does).
/// The correlation rho of the two is measured per ear over the overlap, and the gains
/// w1 = cos^2, w2 = sin^2 are divided by sqrt(w1^2 + w2^2 + 2 rho w1 w2): the power stays constant
/// for every rho >= 0, and equal windows are passed on unchanged.
class OverlapAdder {
 public:
  /// @param overlap  samples, 0 <= overlap <= window / 2
  OverlapAdder(std::ptrdiff_t window, std::ptrdiff_t overlap);

  /// @param window  [channels][window samples]
  /// @return the samples that are final now: [channels][window - overlap]
  [[nodiscard]] Waveform add(const Waveform& window);

  /// @return the tail of the last window: [channels][overlap]
  [[nodiscard]] Waveform flush();

 private:
  std::ptrdiff_t window_;
  std::ptrdiff_t overlap_;
  std::vector<double> rising_;  // how much of the later window is heard, [overlap]
  Waveform tail_;
};

}  // namespace earpoint
