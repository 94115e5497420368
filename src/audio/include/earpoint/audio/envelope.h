#pragma once

#include <span>
#include <vector>

namespace earpoint {

/// The envelope of a signal: the magnitude of the analytic signal, whose spectrum is the signal's
/// without its negative frequencies (Gabor, J. IEE 93, 1946). The signal counts as periodic.
/// @param signal  shape [samples], samples > 0
/// @return  same shape
[[nodiscard]] std::vector<double> hilbert_envelope(std::span<const float> signal);

}  // namespace earpoint
