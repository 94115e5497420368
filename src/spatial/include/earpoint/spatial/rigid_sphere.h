#pragma once

#include <array>
#include <complex>
#include <span>

namespace earpoint {

/// Of the sphere that stands for a head; its ears lie at +-90 degrees.
constexpr double kHeadRadius_m = 0.0875;

/// Pressure of a point source at the two ends of a rigid sphere's diameter (the ears), over what it
/// would be in the sphere's middle without the sphere; the phase is that over the middle's.
/// @param frequency_hz  >= 0
/// @param distance_m    from the middle; below 0.1 m counts as 0.1 m
/// @param towards_left  cosine of the angle between the source and the left end, in [-1, 1]
/// @return  left, right; time runs as exp(+i w t)
/// Source: Duda and Martens, "Range dependence of the response of a spherical head model", JASA 104
/// (1998): the series of spherical Hankel functions, summed until it is good to 1e-7.
[[nodiscard]] std::array<std::complex<double>, 2> rigid_sphere_ears(double frequency_hz,
                                                                    double distance_m,
                                                                    double towards_left);

/// How much earlier (negative) or later each ear of the sphere hears than the middle would: the
/// shortest way around it. Seconds; left, right; arguments as above.
[[nodiscard]] std::array<double, 2> rigid_sphere_delays_s(double distance_m, double towards_left);

/// What a source nearer than the measurement changes at both ears: `rigid_sphere_ears` at its
/// distance over that at the measured distance (distance variation functions). One at the measured
/// distance and beyond. Allocates nothing.
/// @param spectra  left, right; shape [bins] each, from 0 Hz to `nyquist_hz`
void near_field_spectra(double distance_m, double measured_distance_m, double towards_left,
                        double nyquist_hz, std::array<std::span<std::complex<float>>, 2> spectra);

}  // namespace earpoint
