#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include <earpoint/vector3.h>

namespace earpoint {

/// Head-related impulse responses as a SOFA file holds them, in our frame and ear order.
struct SofaFile {
  int sample_rate_hz = 0;
  int taps = 0;  ///< per response
  /// Where the source stood, in the listener's frame (x front, y left, z up), metres.
  std::vector<Vector3> positions_m;
  /// [measurement][ear][tap], ear 0 is the left one; linear pressure.
  std::vector<float> responses;
  /// [measurement][ear]: Data.Delay, to be added before the response; >= 0.
  std::vector<std::array<double, 2>> delays_samples;

  [[nodiscard]] std::span<const float> response(std::size_t measurement, int ear) const {
    return std::span(responses).subspan((measurement * 2 + ear) * taps, taps);
  }
};

/// Reads any SOFA file (AES69) of the convention SimpleFreeFieldHRIR: coordinates spherical or
/// cartesian, any listener position and view, receivers in either order: the left ear is the one
/// that ReceiverPosition puts at positive y. Nothing is normalised, resampled or sorted.
/// @throws InputError if the file is missing, is no SOFA file, follows another convention, has a
///         field missing, of a wrong size or not finite, has a sampling rate below 8 kHz or that
///         is not a whole number, or if sources on the left are louder at the right ear
[[nodiscard]] SofaFile read_sofa(const std::filesystem::path& path);

/// The set used when none is named: $EARPOINT_HRTF if set, else the MIT KEMAR dummy head with its
/// normal pinna (Gardner and Martin, 1994; 710 directions, 1.4 m) that libmysofa installs.
/// @throws InputError naming the Debian package if it is not installed
[[nodiscard]] std::filesystem::path default_hrtf_path();

}  // namespace earpoint
