#include <earpoint/trace/source.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <earpoint/error.h>

namespace earpoint {

Directivity::Directivity(int azimuths, int elevations, std::vector<BandArray> energies)
    : azimuths_(azimuths), elevations_(elevations), energies_(std::move(energies)) {
  EARPOINT_CHECK(azimuths > 0 && elevations > 1);
  EARPOINT_CHECK(std::ssize(energies_) == static_cast<std::ptrdiff_t>(azimuths) * elevations);
  for (const BandArray& bands : energies_) {
    EARPOINT_CHECK(std::all_of(bands.begin(), bands.end(), [](float e) { return e >= 0.0F; }));
  }
}

Directivity Directivity::about_front(std::vector<BandArray> energies) {
  const auto angles = static_cast<int>(energies.size());
  Directivity directivity(1, angles, std::move(energies));
  directivity.table_ = Table::by_angle_from_front;
  return directivity;
}

BandArray Directivity::mean_energy() const {
  if (omnidirectional()) return all_bands(1.0F);
  constexpr int kRows = 180;
  constexpr int kColumns = 360;
  std::array<double, kOctaveBands> sum{};
  double weights = 0.0;
  for (int row = 0; row < kRows; ++row) {
    const double elevation_rad = ((row + 0.5) / kRows - 0.5) * kPi;
    const double weight = std::cos(elevation_rad);
    for (int column = 0; column < kColumns; ++column) {
      const double azimuth_rad = 2.0 * kPi * (column + 0.5) / kColumns;
      const BandArray bands = energy(cartesian_from_spherical(
          {.azimuth_rad = azimuth_rad, .elevation_rad = elevation_rad, .distance_m = 1.0}));
      for (int band = 0; band < kOctaveBands; ++band) {
        sum[band] += weight * static_cast<double>(bands[band]);
      }
      weights += weight;
    }
  }
  BandArray mean;
  for (int band = 0; band < kOctaveBands; ++band) {
    mean[band] = static_cast<float>(sum[band] / weights);
  }
  return mean;
}

BandArray Directivity::energy(const Vector3& direction) const {
  if (omnidirectional()) return all_bands(1.0F);
  if (table_ == Table::by_angle_from_front) {
    const double angle_rad = std::acos(std::clamp(direction.x, -1.0, 1.0));
    const double place = angle_rad / kPi * (elevations_ - 1);
    const int below = std::min(static_cast<int>(place), elevations_ - 2);
    BandArray energy;
    for (int band = 0; band < kOctaveBands; ++band) {
      energy[band] = static_cast<float>(std::lerp(static_cast<double>(energies_[below][band]),
                                                  static_cast<double>(energies_[below + 1][band]),
                                                  place - below));
    }
    return energy;
  }
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
