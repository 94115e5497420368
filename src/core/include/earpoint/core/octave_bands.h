#pragma once

#include <array>

namespace earpoint {

/// The octave bands in which materials, air and directivity are described, and sound is traced.
constexpr int kOctaveBands = 8;
constexpr std::array<double, kOctaveBands> kOctaveBandCentresHz = {62.5, 125.0,  250.0,  500.0,
                                                                   1000, 2000.0, 4000.0, 8000.0};

/// One number per octave band, lowest first.
using BandArray = std::array<float, kOctaveBands>;

/// @return the same number in every band
constexpr BandArray all_bands(float value) {
  BandArray bands{};
  bands.fill(value);
  return bands;
}

}  // namespace earpoint
