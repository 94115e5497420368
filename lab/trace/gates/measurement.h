#pragma once

#include <span>
#include <vector>

#include <earpoint/trace/tracer.h>

namespace earpoint::gates {

/// How an impulse response is measured by the gates: written apart from the code under test.

/// @param half_width  of a band, octaves
/// @return  what `band_of` leaves of a pressure so many octaves from the band's centre
double band_weight(double octaves_away, double half_width);

/// A band of one octave around a centre (or a narrower one), cut out by a zero-phase filter with
/// cosine flanks of half an octave.
/// @param octaves  its width
std::vector<double> band_of(std::span<const float> response, int sample_rate_hz, double centre_hz,
                            double octaves);

/// @return the energy of each whole window
std::vector<double> window_energies(std::span<const double> signal, int window_samples);

/// @return the energy from each sample on (Schroeder, 1965)
std::vector<double> backward_energy(std::span<const double> signal);

/// @return 60 dB over the slope of the straight line through the decay between two levels; throws
///         std::runtime_error if the decay does not reach the lower one
double decay_time_s(std::span<const double> backward, double steps_per_s, double from_db,
                    double to_db);

/// The energy of the octave around a band's centre in the sum of arrivals as they are, without the
/// late field and the renderer's filters: the mean over frequencies, pressure 1 at 1 m being 0 dB.
double arrivals_level_db(const PointResponse& response, int band, double speed_m_per_s);

double energy(std::span<const double> signal);
double decibels(double energy_ratio);

}  // namespace earpoint::gates
