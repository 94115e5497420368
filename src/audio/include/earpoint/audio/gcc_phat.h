#pragma once

#include <limits>
#include <span>

namespace earpoint {

/// How much later `signal` is than `reference`, by the generalised cross-correlation with phase
/// transform, interpolated 16 times: a multiple of 1/16 sample.
///
/// With n = both lengths together, the lag is where |cross-correlation| is largest over
/// -n/2 ... n/2; of equal maxima the first. As in the evaluation that this reproduces there is no
/// regularisation: if any bin of the cross-spectrum is exactly zero, as with a silent channel, the
/// result is -n/2. Ask energy first where that matters.
///
/// @param signal, reference  shape [samples], neither empty; lengths may differ
/// @param max_delay_samples  the result is clamped to +- this
/// Source: Knapp and Carter, IEEE Trans. ASSP 24 (1976).
/// Cost: O(n log n) in double.
[[nodiscard]] double gcc_phat_delay_samples(
    std::span<const float> signal, std::span<const float> reference,
    double max_delay_samples = std::numeric_limits<double>::infinity());

}  // namespace earpoint
