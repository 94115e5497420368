#include <earpoint/trace/energy_histogram.h>

#include "sphere_points.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <earpoint/error.h>

namespace earpoint {
namespace {

std::array<Vector3, kSectors> spread_sectors() {
  std::array<Vector3, kSectors> directions;
  for (int i = 0; i < kSectors; ++i) directions[i] = spiral_direction(i, 0.5, kSectors, 0.0);
  return directions;
}

const std::array<Vector3, kSectors> kDirections = spread_sectors();

int nearest_sector(const Vector3& direction) {
  int nearest = 0;
  double best = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < kSectors; ++i) {
    const double cosine = dot(direction, kDirections[i]);
    if (cosine > best) {
      best = cosine;
      nearest = i;
    }
  }
  return nearest;
}

// The sector of each small square on the faces of a cube around the origin.
constexpr int kSquares = 48;
class SectorCube {
 public:
  SectorCube() {
    for (int face = 0; face < 6; ++face) {
      for (int row = 0; row < kSquares; ++row) {
        for (int column = 0; column < kSquares; ++column) {
          const double a = (column + 0.5) * 2.0 / kSquares - 1.0;
          const double b = (row + 0.5) * 2.0 / kSquares - 1.0;
          const double sign = face % 2 == 0 ? 1.0 : -1.0;
          const std::array<Vector3, 3> points = {{{sign, a, b}, {a, sign, b}, {a, b, sign}}};
          sectors_[(face * kSquares + row) * kSquares + column] =
              static_cast<std::uint8_t>(nearest_sector(points[face / 2]));
        }
      }
    }
  }

  [[nodiscard]] int find(float x, float y, float z) const {
    const float ax = std::abs(x);
    const float ay = std::abs(y);
    const float az = std::abs(z);
    if (ax >= ay && ax >= az) return square(x > 0.0F ? 0 : 1, y / ax, z / ax);
    if (ay >= az) return square(y > 0.0F ? 2 : 3, x / ay, z / ay);
    return square(z > 0.0F ? 4 : 5, x / az, y / az);
  }

 private:
  [[nodiscard]] int square(int face, float a, float b) const {
    constexpr float kHalf = 0.5F * kSquares;
    const int column = std::min(static_cast<int>((a + 1.0F) * kHalf), kSquares - 1);
    const int row = std::min(static_cast<int>((b + 1.0F) * kHalf), kSquares - 1);
    return sectors_[(face * kSquares + row) * kSquares + column];
  }

  std::array<std::uint8_t, std::size_t{6} * kSquares * kSquares> sectors_{};
};

const SectorCube kCube;

}  // namespace

const Vector3& sector_direction(int sector) {
  EARPOINT_DCHECK(sector >= 0 && sector < kSectors);
  return kDirections[sector];
}

int sector_of(float x, float y, float z) { return kCube.find(x, y, z); }

EnergyHistogram::EnergyHistogram(int bins, double bin_s) : bins_(bins), bin_s_(bin_s) {
  EARPOINT_CHECK(bins >= 0 && bin_s > 0.0);
  energies_.assign(static_cast<std::size_t>(bins) * kSectors, BandArray{});
}

void EnergyHistogram::add(const EnergyHistogram& other) {
  EARPOINT_CHECK(other.bins_ == bins_ && other.bin_s_ == bin_s_);
  for (std::size_t i = 0; i < energies_.size(); ++i) {
    for (int band = 0; band < kOctaveBands; ++band) energies_[i][band] += other.energies_[i][band];
  }
}

BandArray EnergyHistogram::bin_energy(int bin) const {
  EARPOINT_DCHECK(bin >= 0 && bin < bins_);
  BandArray sum{};
  for (int sector = 0; sector < kSectors; ++sector) {
    for (int band = 0; band < kOctaveBands; ++band) sum[band] += at(bin, sector)[band];
  }
  return sum;
}

}  // namespace earpoint
