#include "sampling.h"

#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace earpoint {
namespace {

// Whether each box of 2^-a by 2^-(n-a) holds exactly one of 2^n points, for all a.
bool is_net(const std::vector<UnitPair>& points) {
  int n = 0;
  while ((1U << n) < points.size()) ++n;
  for (int a = 0; a <= n; ++a) {
    std::set<std::pair<int, int>> boxes;
    for (const UnitPair& p : points) {
      boxes.emplace(static_cast<int>(p.u * static_cast<float>(1 << a)),
                    static_cast<int>(p.v * static_cast<float>(1 << (n - a))));
    }
    if (boxes.size() != points.size()) return false;
  }
  return true;
}

std::vector<UnitPair> run_of(std::uint32_t first, std::uint32_t count, std::uint32_t seed) {
  std::vector<UnitPair> points;
  for (std::uint32_t i = 0; i < count; ++i) points.push_back(sobol_pair(first + i, seed));
  return points;
}

TEST(Sobol, EveryAlignedRunIsANet) {
  for (const std::uint32_t seed : {1U, 77U, 0xDEADBEEFU}) {
    EXPECT_TRUE(is_net(run_of(0, 64, seed)));
    EXPECT_TRUE(is_net(run_of(5 * 64, 64, seed)));
    EXPECT_TRUE(is_net(run_of(12, 4, seed)));
    EXPECT_TRUE(is_net(run_of(0x10000, 1024, seed)));
  }
  EXPECT_FALSE(is_net(run_of(3, 64, 1)));  // a run that is not aligned: the check can fail
}

TEST(Sobol, SeedsGiveOtherPoints) {
  const UnitPair a = sobol_pair(9, 1);
  const UnitPair b = sobol_pair(9, 2);
  EXPECT_NE(a.u, b.u);
  EXPECT_NE(a.v, b.v);
}

TEST(Sobol, SixteenAtOnceAreTheSamePoints) {
  std::array<std::uint32_t, 16> indices{};
  for (std::uint32_t i = 0; i < 16; ++i) indices[i] = 1000 * i + 3;
  UnitPairs pairs;
  sobol_pairs(indices, 42, pairs);
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(pairs.u[i], sobol_pair(indices[i], 42).u);
    EXPECT_EQ(pairs.v[i], sobol_pair(indices[i], 42).v);
  }
}

TEST(Morton, InterleavesTheBits) {
  EXPECT_EQ(morton_index(0, 0), 0U);
  EXPECT_EQ(morton_index(1, 0), 1U);
  EXPECT_EQ(morton_index(0, 1), 2U);
  EXPECT_EQ(morton_index(5, 3), 0b011011U);
  EXPECT_EQ(morton_index(65535, 65535), 0xFFFFFFFFU);
}

TEST(CosineDirection, HasTheDensityOfCosine) {
  double mean = 0.0;
  double square = 0.0;
  constexpr int kCount = 4096;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const Float3 d = cosine_direction(sobol_pair(i, 3));
    EXPECT_NEAR(norm(d), 1.0F, 1e-6F);  // single precision
    EXPECT_GE(d.z, 0.0F);
    mean += d.z / kCount;
    square += d.x * d.x / kCount;
  }
  // Integrals over the hemisphere: of z 2/3, of x^2 1/4. The net's error is of order 1/4096.
  EXPECT_NEAR(mean, 2.0 / 3.0, 5e-4);
  EXPECT_NEAR(square, 0.25, 5e-4);
}

TEST(Frame, IsRightHandedAndOrthonormal) {
  for (const Float3& n :
       {Float3{0, 0, 1}, Float3{0, 0, -1}, Float3{0.6F, 0, -0.8F}, Float3{-0.48F, 0.64F, 0.6F}}) {
    const Frame frame(n);
    // Single precision.
    EXPECT_NEAR(dot(frame.tangent, frame.bitangent), 0.0F, 1e-6F);
    EXPECT_NEAR(norm(cross(frame.tangent, frame.bitangent) - n), 0.0F, 1e-6F);
    const Float3 there_and_back = frame.to_local(frame.to_world({0.1F, -0.2F, 0.3F}));
    EXPECT_NEAR(norm(there_and_back - Float3{0.1F, -0.2F, 0.3F}), 0.0F, 1e-6F);
  }
}

TEST(Rescale, SpreadsAPartOverTheWhole) {
  EXPECT_FLOAT_EQ(rescale(0.3F, 0.2F, 0.4F), 0.5F);
  EXPECT_EQ(rescale(0.2F, 0.2F, 0.4F), 0.0F);
  EXPECT_LT(rescale(0.4F, 0.2F, 0.4F), 1.0F);
}

}  // namespace
}  // namespace earpoint
