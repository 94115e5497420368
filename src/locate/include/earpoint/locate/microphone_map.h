#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace earpoint {

/// What the near-range microphones and one camera tell of one moment (a window of about a second)
/// of a session. A session with several cameras gives a moment for each of them.
struct NearRangeMoment {
  std::vector<double> near_db;  ///< level at every near-range microphone
  double camera_db = 0.0;       ///< at the camera's ears
  /// How far from the camera everybody is who is followed; nothing: not seen at this moment.
  std::vector<std::optional<double>> distance_m;
  /// How well everybody's direction agrees with the time between the ears, as a logarithm
  /// (DirectionEvidence); empty: not heard.
  std::vector<double> direction_log_likelihood{};
};

/// The paper's rule: who speaks wears the microphone with the largest level in the window.
/// @param silence_db  nothing when no level is above it
[[nodiscard]] std::optional<std::size_t> loudest_microphone(std::span<const double> near_db,
                                                            double silence_db);

/// Who wears which microphone.
struct MicrophoneMap {
  std::vector<std::optional<std::size_t>> person_of;  ///< by microphone
  /// By microphone: how surely it is that person and no other, 0.5 to 1; 0 where there is nobody.
  /// One half where nothing told.
  std::vector<double> certainty;
};

/// Finds out who wears which near-range microphone.
///
/// While one microphone is clearly the loudest, its wearer speaks, and the camera hears them weaker
/// than their microphone by 20 log10 of their distance and a gain. The person whose distances over
/// time (and over cameras) leave the least of that unexplained is the wearer; gains of microphones
/// may differ by some decibels. Where it is given, the direction between the camera's ears tells as
/// well, also when nobody moves. All microphones are assigned at once, by the Hungarian method.
/// @param silence_db  of the near-range microphones: nobody speaks below
/// @throws std::logic_error if moments have different numbers of microphones or people
[[nodiscard]] MicrophoneMap match_microphones(std::span<const NearRangeMoment> moments,
                                              double silence_db);

}  // namespace earpoint
