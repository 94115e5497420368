#pragma once

#include <earpoint/core/octave_bands.h>

namespace earpoint {

/// The state of the air, for the speed of sound and what it swallows.
struct Air {
  double temperature_celsius = 20.0;
  double relative_humidity_percent = 50.0;
  double pressure_kpa = 101.325;
};

/// @throws InputError if a value lies outside what ISO 9613-1 covers with a margin: temperature
///         [-50, 60] degrees Celsius, humidity [0, 100] %, pressure (0, 200] kPa
void check_air(const Air& air);

/// 343.2 m/s at 20 degrees Celsius, growing with the square root of the absolute temperature.
/// @throws InputError as check_air
/// Source: ISO 9613-1:1993, annex A.
[[nodiscard]] double speed_of_sound_m_per_s(const Air& air);

/// Pure-tone attenuation by the air, in dB per metre: classical and rotational losses, and the
/// vibrational relaxation of oxygen and nitrogen.
/// @param frequency_hz  >= 0
/// @throws InputError as check_air
/// Source: ISO 9613-1:1993, equations 3 to 5 and B.1 to B.3. The standard states 10 % accuracy for
/// 0.05 % to 5 % molar water vapour, -20 to 50 degrees Celsius and below 200 kPa.
[[nodiscard]] double air_absorption_db_per_m(double frequency_hz, const Air& air);

/// The same at the octave bands' centres.
[[nodiscard]] BandArray air_absorption_db_per_m(const Air& air);

/// @return the pressure factor 10^(-dB distance / 20) per band, in (0, 1]
[[nodiscard]] BandArray air_gain(const BandArray& absorption_db_per_m, double distance_m);

}  // namespace earpoint
