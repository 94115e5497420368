#include <algorithm>
#include <cmath>
#include <utility>

#include <earpoint/core/error.h>
#include <earpoint/trace/source.h>

namespace earpoint {

Directivity::Directivity(int azimuths, int elevations, std::vector<BandArray> energies)
    : azimuths_(azimuths), elevations_(elevations), energies_(std::move(energies)) {
  EARPOINT_CHECK(azimuths > 0 && elevations > 1);
  EARPOINT_CHECK(std::ssize(energies_) == static_cast<std::ptrdiff_t>(azimuths) * elevations);
  for (const BandArray& bands : energies_) {
    EARPOINT_CHECK(std::all_of(bands.begin(), bands.end(), [](float e) { return e >= 0.0F; }));
  }
}

BandArray Directivity::energy(const Vector3& direction) const {
  if (omnidirectional()) return all_bands(1.0F);
  const Spherical angles = spherical_from_cartesian(direction);
  const double column = (angles.azimuth_rad / (2.0 * kPi) + 0.5) * azimuths_;
  const double row = (angles.elevation_rad / kPi + 0.5) * (elevations_ - 1);
  const int left = static_cast<int>(std::floor(column));
  const int below = std::clamp(static_cast<int>(std::floor(row)), 0, elevations_ - 2);
  const double right_share = column - left;
  const double above_share = row - below;
  const auto cell = [&](int r, int c) -> const BandArray& {
    return energies_[static_cast<std::size_t>(r) * azimuths_ + (c % azimuths_)];
  };
  BandArray energy;
  for (int band = 0; band < kOctaveBands; ++band) {
    const double low = std::lerp(static_cast<double>(cell(below, left)[band]),
                                 static_cast<double>(cell(below, left + 1)[band]), right_share);
    const double high =
        std::lerp(static_cast<double>(cell(below + 1, left)[band]),
                  static_cast<double>(cell(below + 1, left + 1)[band]), right_share);
    energy[band] = static_cast<float>(std::lerp(low, high, above_share));
  }
  return energy;
}

}  // namespace earpoint
