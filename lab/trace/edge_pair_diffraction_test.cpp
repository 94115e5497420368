#include "edge_pair_diffraction.h"

#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kSpeed = 343.2;
const EdgeInterval kLong[] = {{-60.0, 60.0}};
const EdgeInterval kDoor[] = {{-1.0, 1.0}};

// The end of a wall along -y between x = 0 and x = its thickness.
struct WallEnd {
  double thickness_m;
  std::span<const EdgeInterval> intervals = kLong;

  // A place in coordinates of either edge, with the angle from the face on the wall's end.
  [[nodiscard]] FacePlace place(double x, double y, double z = 0.0) const {
    FacePlace place{.z_m = z, .points = {}};
    for (int edge = 0; edge < 2; ++edge) {
      const double across = edge == 0 ? x : thickness_m - x;
      double angle = std::atan2(y, across);
      if (angle < -0.5 * kPi) angle += 2.0 * kPi;
      const bool is_behind_other = y < 0.0 && across > 0.0;
      place.points[edge] = {std::hypot(across, y), std::max(0.0, angle), {}};
      if (!is_behind_other) place.points[edge].in_sight.assign(intervals.begin(), intervals.end());
    }
    return place;
  }

  [[nodiscard]] EdgeFace face() const {
    EdgeFace face;
    face.width_m = thickness_m;
    face.open_angle_rad = {1.5 * kPi, 1.5 * kPi};
    return face;
  }

  [[nodiscard]] DiffractionSpectrum over(const FacePlace& source, const FacePlace& receiver) const {
    return diffract_over_face(face(), source, receiver, 0.0, kSpeed);
  }

  // The sound of all orders.
  [[nodiscard]] DiffractionSpectrum whole(const FacePlace& source,
                                          const FacePlace& receiver) const {
    DiffractionSpectrum sum = over(source, receiver);
    for (int edge = 0; edge < 2; ++edge) {
      const FacePoint& from = source.points[edge];
      const FacePoint& to = receiver.points[edge];
      if (from.in_sight.empty() || to.in_sight.empty()) continue;
      const EdgePoint here{from.radius_m, from.angle_rad, source.z_m};
      const EdgePoint there{to.radius_m, to.angle_rad, receiver.z_m};
      const DiffractionSpectrum sound =
          diffract({.open_angle_rad = 1.5 * kPi}, here, there, intervals, {}, kSpeed);
      const double way_m = find_apex(here, there, intervals).distance_m;
      for (int i = 0; i < kDiffractionFrequencies; ++i) {
        const double wave_number = 2.0 * kPi * diffraction_frequency_hz(i) / kSpeed;
        sum[i] += sound[i] * std::polar(1.0, -wave_number * way_m);
      }
    }
    return sum;
  }
};

TEST(EdgePairDiffraction, IsReciprocal) {
  const WallEnd wall{0.1};
  const auto here = wall.place(-2.0, 0.1);
  for (const double y : {-0.7, 0.2}) {
    const auto there = wall.place(1.3, y, 0.4);
    const DiffractionSpectrum a = wall.over(here, there);
    const DiffractionSpectrum b = wall.over(there, here);
    for (int i = 0; i < kDiffractionFrequencies; ++i) {
      // Both directions have the same number of orders, but different steps of the line.
      EXPECT_LT(std::abs(a[i] - b[i]), 2e-3 * std::abs(a[i]) + 1e-5) << y << " " << i;
      EXPECT_GT(std::abs(a[i]), 1e-4) << "there is a sound";
    }
  }
}

TEST(EdgePairDiffraction, ThinWallIsAScreen) {
  // A wall of 1 cm is 1/270 to 1/50 of a wave at 125 to 700 Hz. It acts like a screen that ends a
  // little further out, by about a third of the thickness.
  const WallEnd wall{0.01};
  const auto source = wall.place(-2.0, -0.4);
  const auto receiver = wall.place(1.8, -0.6, 0.4);
  const DiffractionSpectrum thick = wall.whole(source, receiver);
  // Around a screen along -y, angles from its left side.
  const double source_angle = std::atan2(2.0, 0.4);
  const double receiver_angle = 2.0 * kPi - std::atan2(1.8, 0.6);
  const DiffractionSpectrum thin =
      diffract({.open_angle_rad = 2.0 * kPi}, {std::hypot(2.0, 0.4), source_angle, 0.0},
               {std::hypot(1.8, 0.6), receiver_angle, 0.4}, kLong, {}, kSpeed);
  for (int i = 3; i < 12; ++i) {
    // What those 3 mm change of paths around 4 m is far below audible.
    EXPECT_NEAR(20.0 * std::log10(std::abs(thick[i]) / std::abs(thin[i])), 0.0, 0.2) << i;
  }
}

TEST(EdgePairDiffraction, HasNoJumpWhereAnEdgeGoesOutOfSight) {
  for (const double thickness : {0.05, 0.1, 0.3}) {
    for (const auto intervals :
         {std::span<const EdgeInterval>(kLong), std::span<const EdgeInterval>(kDoor)}) {
      for (const double source_y : {-0.5, 0.2}) {
        const WallEnd wall{thickness, intervals};
        const auto source = wall.place(-1.5, source_y);
        const DiffractionSpectrum above = wall.whole(source, wall.place(1.2, 1e-5, 0.4));
        const DiffractionSpectrum below = wall.whole(source, wall.place(1.2, -1e-5, 0.4));
        for (int i = 0; i < kDiffractionFrequencies; ++i) {
          // A point source's second order differs from that of a line source by its spreading: 2 %,
          // most if the paths are short against a wave of 5 m.
          EXPECT_LT(std::abs(above[i] - below[i]), (i < 6 ? 0.05 : 0.03) * std::abs(above[i]))
              << thickness << " " << source_y << " " << i;
        }
      }
    }
  }
}

TEST(EdgePairDiffraction, PlacesOnTheFacesPlaneHaveALimit) {
  // The sound on the plane is the limit of the sound close to it: 1e-5 m turn the shortest wave, of
  // 3.4 cm, by 2e-3.
  const WallEnd wall{0.1};
  const DiffractionSpectrum on = wall.whole(wall.place(-1.0, 0.0), wall.place(1.2, -0.5, 0.4));
  const DiffractionSpectrum near = wall.whole(wall.place(-1.0, 1e-5), wall.place(1.2, -0.5, 0.4));
  for (int i = 0; i < kDiffractionFrequencies; ++i) {
    EXPECT_LT(std::abs(on[i] - near[i]), 2e-3 * std::abs(on[i])) << i;
  }
}

TEST(EdgePairDiffraction, FaceThatAbsorbsPassesLess) {
  const WallEnd wall{0.3};
  EdgeFace soft = wall.face();
  soft.reflection = all_bands(0.3F);
  soft.other_reflection = {all_bands(0.3F), all_bands(0.3F)};
  const auto source = wall.place(-1.5, -0.3);
  const auto receiver = wall.place(1.5, -0.3);
  const DiffractionSpectrum hard = wall.over(source, receiver);
  const DiffractionSpectrum quiet = diffract_over_face(soft, source, receiver, 0.0, kSpeed);
  for (int i = 0; i < kDiffractionFrequencies; ++i)
    EXPECT_LT(std::abs(quiet[i]), std::abs(hard[i]));
}

}  // namespace
}  // namespace earpoint
