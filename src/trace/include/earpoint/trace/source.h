#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <earpoint/core/octave_bands.h>
#include <earpoint/core/pose.h>

namespace earpoint {

/// How much energy a source sends into each direction, per octave band, relative to its front.
/// The default is the same in all directions.
class Directivity {
 public:
  Directivity() = default;

  /// A table over direction, interpolated linearly in energy.
  /// @param azimuths    columns evenly over [-180, 180) degrees, starting at -180; > 0
  /// @param elevations  rows evenly over [-90, 90] degrees; > 1
  /// @param energies    [elevations][azimuths], >= 0
  /// @throws std::logic_error if the sizes do not fit or an energy is negative
  Directivity(int azimuths, int elevations, std::vector<BandArray> energies);

  [[nodiscard]] bool omnidirectional() const { return energies_.empty(); }

  /// @param direction  unit length, in the source's frame (x is its front)
  [[nodiscard]] BandArray energy(const Vector3& direction) const;

 private:
  int azimuths_ = 0;
  int elevations_ = 0;
  std::vector<BandArray> energies_;
};

/// What makes sound: at 1 m in front, in free field, it has a level of 0 dB in every band.
struct Source {
  Pose world_from_source{};  ///< the position, and the front that a directivity refers to
  Directivity directivity{};
  /// The person whose mouth this is, an index into `Scene::instances`: that body does not stand in
  /// the way of what leaves the mouth, since the directivity already holds its shadow.
  std::optional<std::uint32_t> body{};
};

}  // namespace earpoint
