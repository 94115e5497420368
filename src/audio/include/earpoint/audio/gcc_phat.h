#pragma once

#include <limits>
#include <memory>
#include <span>

namespace earpoint {

/// Finds how much later one signal is than another, by the generalised cross-correlation with phase
/// transform, interpolated 16 times: a multiple of 1/16 sample.
///
/// With n = both lengths together, the lag is where |cross-correlation| is largest over -n/2 ...
/// n/2; of equal maxima the first. As in the evaluation that this reproduces there is no
/// regularisation: if any bin of the cross-spectrum is exactly zero, as with a silent signal, the
/// result is -n/2. Ask for energy first where that matters.
///
/// One object plans for one pair of lengths; use one per thread.
/// Source: Knapp and Carter, IEEE Trans. ASSP 24 (1976).
/// Cost: O(n log n) in double; about 160 n bytes.
class GccPhat {
 public:
  /// @param signal_samples, reference_samples  > 0
  GccPhat(int signal_samples, int reference_samples);
  ~GccPhat();
  GccPhat(GccPhat&&) noexcept;
  GccPhat& operator=(GccPhat&&) noexcept;

  /// @param signal, reference  of the lengths given to the constructor
  /// @return  in samples; positive if `signal` is later than `reference`
  [[nodiscard]] double delay_samples(std::span<const float> signal,
                                     std::span<const float> reference);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The same for one pair.
/// @param signal, reference  neither empty; lengths may differ
/// @param max_delay_samples  the result is clamped to +- this
[[nodiscard]] double gcc_phat_delay_samples(
    std::span<const float> signal, std::span<const float> reference,
    double max_delay_samples = std::numeric_limits<double>::infinity());

}  // namespace earpoint
