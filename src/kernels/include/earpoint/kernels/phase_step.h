#pragma once

#include <complex>
#include <span>

namespace earpoint::kernels {

/// A step of fast Griffin-Lim for one frame: every bin gets its magnitude, and the phase of
/// transform + momentum * (transform - heard). Allocates nothing.
/// Source: Perraudin, Balazs and Sondergaard, A fast Griffin-Lim algorithm, WASPAA 2013.
/// @param transform    of what the frame sounds like, [bins]; replaced by the result
/// @param heard        the transform of the step before, [bins]; replaced by that of this step
/// @param magnitude    [bins]
/// @param power_floor  > 0; a bin far below it has no phase and becomes quieter
void step_phases(std::span<std::complex<float>> transform, std::span<std::complex<float>> heard,
                 std::span<const float> magnitude, float momentum, float power_floor);

}  // namespace earpoint::kernels
