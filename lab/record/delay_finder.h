#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/audio/fft.h>

namespace earpoint {

/// A place where a sound may be found again: the direct sound or an early reflection.
struct DelayCandidate {
  double lag_samples = 0.0;  ///< of the template's beginning in the longer sound
  double height = 0.0;       ///< of the correlation, over that of the highest
};

/// Finds a short sound again in a longer one: generalised cross-correlation with phase transform
/// over the bins in which the short sound has energy. One object per pair of lengths and thread.
class DelayFinder {
 public:
  /// @param template_samples, search_samples  > 0; lags are 0 to search_samples
  DelayFinder(int template_samples, int search_samples, int sample_rate_hz);

  /// @param sound  shape [template_samples]
  void set_template(std::span<const float> sound);

  /// @param sound  shape [template_samples + search_samples]
  /// @return  the highest peaks by falling height, at most six; none if either is silent
  [[nodiscard]] std::vector<DelayCandidate> find(std::span<const float> sound);

 private:
  int search_samples_;
  std::size_t first_bin_;
  std::size_t last_bin_;
  RealFft<float> fft_;
  std::vector<float> window_;
  std::vector<float> signal_;
  std::vector<std::complex<float>> template_;
  std::vector<float> weight_;  ///< 0 where the template has no energy
  std::vector<std::complex<float>> spectrum_;
};

}  // namespace earpoint
