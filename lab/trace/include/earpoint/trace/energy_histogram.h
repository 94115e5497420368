#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <earpoint/core/octave_bands.h>
#include <earpoint/vector3.h>

namespace earpoint {

/// Directions of arrival are divided into sectors: evenly spread over the sphere, in the world's
/// frame, so that a listener may turn the head after the trace.
constexpr int kSectors = 32;

/// @return the middle of a sector, unit length
const Vector3& sector_direction(int sector);

/// @return the sector of a direction (any length but zero): the nearest middle, to within 4 degrees
int sector_of(float x, float y, float z);

/// Energy that arrives at a point over time, by direction and octave band: squared pressure,
/// relative to that at 1 m from the source in free field.
class EnergyHistogram {
 public:
  EnergyHistogram() = default;
  /// @param bins   >= 0
  /// @param bin_s  the width of one bin, > 0; the first starts when the source sounds
  EnergyHistogram(int bins, double bin_s);

  [[nodiscard]] int bins() const { return bins_; }
  [[nodiscard]] double bin_s() const { return bin_s_; }

  [[nodiscard]] BandArray& at(int bin, int sector) {
    return energies_[static_cast<std::size_t>(bin) * kSectors + sector];
  }
  [[nodiscard]] const BandArray& at(int bin, int sector) const {
    return energies_[static_cast<std::size_t>(bin) * kSectors + sector];
  }

  /// Adds another of the same shape.
  void add(const EnergyHistogram& other);

  /// @return the energy of a bin from all directions
  [[nodiscard]] BandArray bin_energy(int bin) const;

 private:
  int bins_ = 0;
  double bin_s_ = 0.0;
  std::vector<BandArray> energies_;  // [bin][sector]
};

}  // namespace earpoint
