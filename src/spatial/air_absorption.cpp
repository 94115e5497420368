#include <earpoint/spatial/air_absorption.h>

#include <cmath>

#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kReferencePressureKpa = 101.325;
constexpr double kReferenceTemperatureK = 293.15;
constexpr double kTriplePointK = 273.16;
constexpr double kZeroCelsiusK = 273.15;

void check_range(const char* field, double value, double low, double high, const char* unit) {
  if (!(value >= low && value <= high)) {
    throw InputError(fmt::format("air: {}", field),
                     fmt::format("expected {} to {} {}, found {}", low, high, unit, value));
  }
}

// The molar concentration of water vapour, in percent.
double water_vapour_percent(const Air& air, double temperature_k, double relative_pressure) {
  const double exponent = -6.8346 * std::pow(kTriplePointK / temperature_k, 1.261) + 4.6151;
  return air.relative_humidity_percent * std::pow(10.0, exponent) / relative_pressure;
}

}  // namespace

void check_air(const Air& air) {
  check_range("temperature", air.temperature_celsius, -50.0, 60.0, "degrees Celsius");
  check_range("humidity", air.relative_humidity_percent, 0.0, 100.0, "%");
  check_range("pressure", air.pressure_kpa, 1.0, 200.0, "kPa");
}

double speed_of_sound_m_per_s(const Air& air) {
  check_air(air);
  return 343.2 * std::sqrt((air.temperature_celsius + kZeroCelsiusK) / kReferenceTemperatureK);
}

double air_absorption_db_per_m(double frequency_hz, const Air& air) {
  check_air(air);
  EARPOINT_CHECK(frequency_hz >= 0.0);
  const double kelvin = air.temperature_celsius + kZeroCelsiusK;
  const double ratio = kelvin / kReferenceTemperatureK;
  const double pressure = air.pressure_kpa / kReferencePressureKpa;
  const double vapour = water_vapour_percent(air, kelvin, pressure);

  // Relaxation frequencies of oxygen and nitrogen, in Hz.
  const double oxygen_hz = pressure * (24.0 + 4.04e4 * vapour * (0.02 + vapour) / (0.391 + vapour));
  const double nitrogen_hz =
      pressure / std::sqrt(ratio) *
      (9.0 + 280.0 * vapour * std::exp(-4.170 * (std::cbrt(1.0 / ratio) - 1.0)));

  const double square = frequency_hz * frequency_hz;
  const double classical = 1.84e-11 / pressure * std::sqrt(ratio);
  const double oxygen = 0.01275 * std::exp(-2239.1 / kelvin) / (oxygen_hz + square / oxygen_hz);
  const double nitrogen =
      0.1068 * std::exp(-3352.0 / kelvin) / (nitrogen_hz + square / nitrogen_hz);
  return 8.686 * square * (classical + std::pow(ratio, -2.5) * (oxygen + nitrogen));
}

BandArray air_absorption_db_per_m(const Air& air) {
  BandArray bands{};
  for (int band = 0; band < kOctaveBands; ++band) {
    bands[band] = static_cast<float>(air_absorption_db_per_m(kOctaveBandCentresHz[band], air));
  }
  return bands;
}

BandArray air_gain(const BandArray& absorption_db_per_m, double distance_m) {
  BandArray gain{};
  for (int band = 0; band < kOctaveBands; ++band) {
    gain[band] = static_cast<float>(std::pow(10.0, -absorption_db_per_m[band] * distance_m / 20.0));
  }
  return gain;
}

}  // namespace earpoint
