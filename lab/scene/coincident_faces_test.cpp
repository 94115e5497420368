#include <gtest/gtest.h>

#include <earpoint/scene/coincident_faces.h>

namespace earpoint {
namespace {

using Positions = std::vector<std::array<float, 3>>;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// A floor of two triangles, 4 x 4 m, and the foot of a cupboard on it, 1 x 1 m, seen from below.
struct FloorAndFoot {
  Positions positions = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0},
                         {1, 2, 0}, {1, 3, 0}, {2, 3, 0}, {2, 2, 0}};
  Triangles triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
};

std::vector<std::uint32_t> partners_of(const CoincidentFaces& faces, std::uint32_t triangle) {
  const auto found = faces.partners(triangle);
  return {found.begin(), found.end()};
}

const auto kAny = [](std::uint32_t) { return true; };

TEST(CoincidentFaces, AreThoseThatShareArea) {
  const FloorAndFoot mesh;
  const CoincidentFaces faces(mesh.positions, mesh.triangles);
  // The foot lies beyond the floor's diagonal and touches it only at one corner, without common
  // area.
  EXPECT_EQ(partners_of(faces, 0), (std::vector<std::uint32_t>{}));
  EXPECT_EQ(partners_of(faces, 1), (std::vector<std::uint32_t>{2, 3}));
  EXPECT_EQ(partners_of(faces, 2), (std::vector<std::uint32_t>{1}));
  EXPECT_EQ(partners_of(faces, 3), (std::vector<std::uint32_t>{1}));
}

TEST(CoincidentFaces, AreNoneWhereAStepLiesBetween) {
  FloorAndFoot mesh;
  for (std::size_t i = 4; i < 8; ++i) mesh.positions[i][2] = 1e-3F;
  const CoincidentFaces faces(mesh.positions, mesh.triangles);
  for (std::uint32_t i = 0; i < 4; ++i) EXPECT_TRUE(faces.partners(i).empty()) << i;
}

TEST(CoincidentFaces, AreFoundThroughTheRoundingOfATurnedModel) {
  // The same slanted triangle twice, once moved by the rounding of its coordinates.
  const Positions positions = {{3, 2, 1},          {3.5F, 2.25F, 1.75F},      {2.75F, 2.5F, 1.5F},
                               {3, 2, 1.0000002F}, {3.5F, 2.2500002F, 1.75F}, {2.75F, 2.5F, 1.5F}};
  const CoincidentFaces faces(positions, Triangles{{0, 1, 2}, {5, 4, 3}});
  EXPECT_EQ(partners_of(faces, 0), (std::vector<std::uint32_t>{1}));
}

TEST(CoincidentFaces, AgreeOnOneWhicheverARayMeetsFirst) {
  const FloorAndFoot mesh;
  const CoincidentFaces faces(mesh.positions, mesh.triangles);
  const std::array<float, 3> down = {0.1F, 0.05F, -1};
  const std::array<float, 3> above_foot = {1.3F, 2.7F, 1};
  EXPECT_EQ(faces.on_top(1, above_foot, down, kAny), 2U);
  EXPECT_EQ(faces.on_top(2, above_foot, down, kAny), 2U);
  // Beside the foot, and with a ray that ignores the foot.
  EXPECT_EQ(faces.on_top(1, {0.2F, 3.7F, 1}, down, kAny), 1U);
  EXPECT_EQ(faces.on_top(1, above_foot, down, [](std::uint32_t i) { return i < 2; }), 1U);
}

}  // namespace
}  // namespace earpoint
