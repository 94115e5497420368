#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/audio/fft.h>

namespace earpoint {

/// Which filter is looked for.
struct FilterShape {
  std::ptrdiff_t before = 0;  ///< taps that look ahead in the input
  std::ptrdiff_t after = 0;   ///< taps from the present backwards, > 0
};

/// Finds the filter between two sounds, the finite Wiener filter: the h that minimises
///   sum_t (output[t] - sum_k h[k] input[lead + t - k])^2 + regularisation * E * sum_k h[k]^2
/// with E the input's energy. Only samples that `output` has are asked for, so that nothing is
/// assumed of what lies before or behind them; the input is zero where it is not given.
///
/// Solved by conjugate gradients on the normal equations, whose matrix is applied by Fourier
/// transforms. A fixed number of steps, which is part of the regularisation: what the input hardly
/// holds is not made up.
/// One object per thread and shape. Source: Hestenes and Stiefel (1952), CGNR.
class FilterFit {
 public:
  struct Options {
    double regularisation = 1e-4;
    int steps = 16;
  };

  /// @param lead     input samples before the output's first
  /// @param samples  of the output
  FilterFit(FilterShape shape, std::ptrdiff_t lead, std::ptrdiff_t samples, Options options);

  /// @param input   [lead + samples]
  /// @param output  [samples]
  /// @return [before + after]: first the tap that looks farthest ahead; zeros for a silent input
  [[nodiscard]] std::vector<float> fit(std::span<const float> input, std::span<const float> output);

 private:
  /// matrix^T (matrix * taps); both of [taps]
  void apply_normal(std::span<const float> taps, std::vector<float>& result);
  void back_project(std::span<const float> output, std::vector<float>& taps);

  FilterShape shape_;
  std::ptrdiff_t lead_;
  std::ptrdiff_t samples_;
  Options options_;
  RealFft<float> fft_;
  std::vector<std::complex<float>> input_spectrum_;
  std::vector<std::complex<float>> spectrum_;
  std::vector<float> circle_;
};

}  // namespace earpoint
