#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/core/axes.h>
#include <earpoint/core/random.h>

namespace earpoint {
namespace {

void expect_axes_of(const Quaternion& q) {
  const Vector3 x = rotate(q, {1, 0, 0});
  const Vector3 y = rotate(q, {0, 1, 0});
  const Vector3 z = rotate(q, {0, 0, 1});
  const Quaternion found = quaternion_from_axes(x, y, z);
  EXPECT_NEAR(norm(rotate(found, {1, 0, 0}) - x), 0.0, 1e-12);
  EXPECT_NEAR(norm(rotate(found, {0, 1, 0}) - y), 0.0, 1e-12);
  EXPECT_NEAR(norm(rotate(found, {0, 0, 1}) - z), 0.0, 1e-12);
  EXPECT_NEAR(found.w * found.w + found.x * found.x + found.y * found.y + found.z * found.z, 1.0,
              1e-12);
}

TEST(Axes, GiveBackTheRotationThatTurnedThem) {
  RandomStream random(1);
  for (int i = 0; i < 200; ++i) {
    expect_axes_of(
        normalized(Quaternion{random.normal(), random.normal(), random.normal(), random.normal()}));
  }
}

TEST(Axes, TurnHalfAroundEachOfThem) {
  // No trace to divide by.
  expect_axes_of({0, 1, 0, 0});
  expect_axes_of({0, 0, 1, 0});
  expect_axes_of({0, 0, 0, 1});
  expect_axes_of({0, std::sqrt(0.5), std::sqrt(0.5), 0});
  expect_axes_of({1, 0, 0, 0});
}

}  // namespace
}  // namespace earpoint
