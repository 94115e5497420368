#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/locate/decode_people.h>
#include <earpoint/people/description.h>

namespace earpoint {
namespace {

constexpr int kRows = 4;
constexpr int kColumns = 8;

/// A map without people.
std::vector<float> empty_map() {
  std::vector<float> map(PeopleDescription::kOutputs * kRows * kColumns, 0.0F);
  std::fill_n(map.begin(), kRows * kColumns, -10.0F);
  return map;
}

void put(std::vector<float>& map, int output, int row, int column, double value) {
  map[(output * kRows + row) * kColumns + column] = static_cast<float>(value);
}

TEST(DecodePeople, PutsTheBoxAroundTheMiddle) {
  std::vector<float> map = empty_map();
  put(map, 0, 1, 2, 2.0);
  put(map, 1, 1, 2, 0.5);             // the middle lies at 3 cells of 8
  put(map, 2, 1, 2, -0.5);            // at 1 cell of 4
  put(map, 3, 1, 2, std::log(0.5));   // 16 pixels: 2 cells
  put(map, 4, 1, 2, std::log(0.25));  // 8 pixels: 1 cell
  const auto people = decode_people(map, kRows, kColumns);
  ASSERT_EQ(people.size(), 1U);
  // float32's rounding of the map.
  EXPECT_NEAR(people[0].box.x_min, 2.0 / 8, 1e-6);
  EXPECT_NEAR(people[0].box.x_max, 4.0 / 8, 1e-6);
  EXPECT_NEAR(people[0].box.y_min, 0.5 / 4, 1e-6);
  EXPECT_NEAR(people[0].box.y_max, 1.5 / 4, 1e-6);
  EXPECT_NEAR(people[0].score, 1.0 / (1.0 + std::exp(-2.0)), 1e-9);
}

TEST(DecodePeople, TakesTheSurestOfNeighboursAndCutsAtTheEdges) {
  std::vector<float> map = empty_map();
  put(map, 0, 0, 0, 3.0);
  put(map, 0, 0, 1, 2.9);
  put(map, 0, 3, 7, 1.0);
  const auto people = decode_people(map, kRows, kColumns);
  ASSERT_EQ(people.size(), 2U);
  EXPECT_GT(people[0].score, people[1].score);
  EXPECT_EQ(people[0].box.x_min, 0.0);
  EXPECT_EQ(people[1].box.x_max, 1.0);
}

TEST(DecodePeople, LeavesOutTheUnsureAndWhatIsNoNumber) {
  std::vector<float> map = empty_map();
  put(map, 0, 1, 1, std::log(0.3 / 0.7));
  put(map, 0, 3, 5, std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(decode_people(map, kRows, kColumns, 0.35).empty());
  EXPECT_EQ(decode_people(map, kRows, kColumns, 0.25).size(), 1U);
}

}  // namespace
}  // namespace earpoint
