#pragma once

#include <span>
#include <vector>

namespace earpoint {

/// How a room's sound decays, from an impulse response as in ISO 3382-1. All of these
/// - start at the direct sound: the first sample within 20 dB of the largest;
/// - integrate the squared response backwards (Schroeder, JASA 37, 1965);
/// - stop where the decay meets the noise (or the end of the response) and put the energy of a
///   continued exponential decay instead of the rest (Lundeby et al., Acustica 81, 1995), so that
///   neither noise nor a cut-off tail bends the curve.
/// @param impulse_response  one channel, shape [samples], linear pressure
/// @param sample_rate_hz    > 0
/// @throws InputError if the response is silent, holds a sample that is not finite, or its decay
///         does not reach the level that is asked for
/// Cost: O(samples); allocates.

/// Early decay time: six times the decay from 0 to -10 dB, by linear regression. Seconds.
[[nodiscard]] double early_decay_time_s(std::span<const float> impulse_response,
                                        double sample_rate_hz);

/// T20: reverberation time extrapolated from -5 to -25 dB. Seconds.
[[nodiscard]] double reverberation_time_t20_s(std::span<const float> impulse_response,
                                              double sample_rate_hz);

/// T30: reverberation time extrapolated from -5 to -35 dB. Seconds.
[[nodiscard]] double reverberation_time_t30_s(std::span<const float> impulse_response,
                                              double sample_rate_hz);

/// C50: energy of the first 50 ms over that of all later, in dB. InputError if nothing is later.
[[nodiscard]] double clarity_c50_db(std::span<const float> impulse_response, double sample_rate_hz);

/// The decay curve that the times are read from, in dB, from the direct sound (0 dB) to where the
/// decay meets the noise; shape [samples up to there].
[[nodiscard]] std::vector<double> energy_decay_db(std::span<const float> impulse_response,
                                                  double sample_rate_hz);

}  // namespace earpoint
