#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <earpoint/core/octave_bands.h>
#include <earpoint/pose.h>

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

  /// The same all around the axis to the front, interpolated linearly in energy.
  /// @param energies  evenly over the angle from the front, from 0 to 180 degrees; two or more, all
  ///                  >= 0
  /// @throws std::logic_error if there are fewer or an energy is negative
  static Directivity about_front(std::vector<BandArray> energies);

  [[nodiscard]] bool omnidirectional() const { return energies_.empty(); }

  /// @param direction  unit length, in the source's frame (x is its front)
  [[nodiscard]] BandArray energy(const Vector3& direction) const;

  /// The mean over the sphere, per band: what the source sends in all, over what an omnidirectional
  /// source of the same level in front sends. Integrated in steps of a degree.
  [[nodiscard]] BandArray mean_energy() const;

 private:
  enum class Table { by_azimuth_and_elevation, by_angle_from_front };

  Table table_ = Table::by_azimuth_and_elevation;
  int azimuths_ = 0;
  int elevations_ = 0;  // or angles from the front
  std::vector<BandArray> energies_;
};

/// How speech spreads from a talker: measured at a normal level every 15 degrees around the head,
/// in octave bands from 125 Hz (62.5 Hz is taken as 125 Hz), and taken as the same all around the
/// axis through the mouth, since other heights were not measured. Behind, 4 dB less than in front
/// at 125 Hz and 26 dB less at 8 kHz. The shadow of head and body is in it: name the talker's own
/// body as `Source::body`.
///
/// Speech that was recorded in front keeps its spectrum in front; the power that goes into the room
/// is less than an omnidirectional source's, as `mean_energy` says.
/// Source: Monson, Hunter and Story, "Horizontal directivity of low- and high-frequency energy in
/// speech and singing", JASA 132 (2012), Table I, by way of transcriptions.
Directivity speech_directivity();

/// What makes sound: at 1 m in front, in free field, it has a level of 0 dB in every band.
struct Source {
  Pose world_from_source{};  ///< the position, and the front that a directivity refers to
  Directivity directivity{};
  /// The person whose mouth this is, an index into `Scene::instances`: that body does not stand in
  /// the way of what leaves the mouth, since the directivity already holds its shadow.
  std::optional<std::uint32_t> body{};
};

}  // namespace earpoint
