#pragma once

#include "wedge_diffraction.h"

#include <complex>

namespace earpoint {

/// Hankel function of the second kind and order 0: a wave of two dimensions that goes outwards.
/// @param z  not 0, real part >= 0, imaginary part <= 0
/// @return  within 1e-4 of its magnitude
/// Source: Abramowitz and Stegun, 9.1.12, 9.1.13 and 9.2.8.
std::complex<double> hankel(std::complex<double> z);

/// Sound of a line source that makes hankel(wave_number * distance) in free field, diffracted by an
/// endless rigid wedge: the first-order integral over the complex angle, exact.
/// @param source, receiver  z has no meaning
std::complex<double> line_sound_past_wedge(double open_angle_rad, const EdgePoint& source,
                                           const EdgePoint& receiver, const UnbentSound& unbent,
                                           double wave_number);

}  // namespace earpoint
