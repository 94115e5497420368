#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/people/description.h>
#include <earpoint/train/people_example.h>

namespace earpoint {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 32;
constexpr int kColumns = kWidth / PeopleDescription::kCell;
constexpr std::size_t kCells = std::size_t{kColumns} * (kHeight / PeopleDescription::kCell);

/// A picture of a white person on black.
Image person_picture(const Box& box) {
  Image picture(2 * kWidth, 2 * kHeight, 3);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const double across = (x + 0.5) / picture.width();
      const double down = (y + 0.5) / picture.height();
      if (across < box.x_min || across > box.x_max || down < box.y_min || down > box.y_max)
        continue;
      for (int c = 0; c < 3; ++c) picture.at(x, y, c) = 255;
    }
  }
  return picture;
}

const Box kBox{.x_min = 0.25, .y_min = 0.25, .x_max = 0.5, .y_max = 0.875};

TEST(PeopleExample, MarksTheCellOfTheMiddleWithItsBox) {
  const PeoplePicture labels{"x", {{kBox, 1.0}}};
  const TrainingExample example =
      people_example(plain_people_view(person_picture(kBox), labels, kWidth, kHeight));
  const std::vector<float>& middles = example.inputs.at(std::string(kMiddlesInput));
  const std::vector<float>& boxes = example.inputs.at(std::string(kBoxesInput));
  ASSERT_EQ(middles.size(), kCells);
  // Middle (24, 18) pixels.
  constexpr std::size_t kCell = 2 * kColumns + 3;
  EXPECT_EQ(middles[kCell], 1.0F);
  EXPECT_EQ(std::ranges::count(middles, 1.0F), 1);
  EXPECT_LT(middles[kCell + 1], 1.0F);
  EXPECT_GT(middles[kCell + 1], 0.0F);
  EXPECT_EQ(boxes[kCell], 16.0F);
  EXPECT_EQ(boxes[kCells + kCell], 8.0F);
  EXPECT_EQ(boxes[2 * kCells + kCell], 32.0F);
  EXPECT_EQ(boxes[3 * kCells + kCell], 28.0F);
  EXPECT_EQ(example.inputs.at(std::string(kBoxWeightsInput))[kCell], 1.0F);
  EXPECT_EQ(example.inputs.at(std::string(kTruthInput))[4], 1.0F);
}

TEST(PeopleExample, WhoIsHardlySeenIsNeitherPersonNorBackground) {
  const PeoplePicture labels{"x", {{kBox, 0.2}}};
  const TrainingExample example =
      people_example(plain_people_view(person_picture(kBox), labels, kWidth, kHeight));
  const std::vector<float>& background = example.inputs.at(std::string(kBackgroundInput));
  EXPECT_EQ(std::ranges::count(example.inputs.at(std::string(kMiddlesInput)), 1.0F), 0);
  EXPECT_EQ(background[2 * kColumns + 3], 0.0F);
  EXPECT_EQ(background[7], 1.0F);
  EXPECT_EQ(example.inputs.at(std::string(kTruthInput))[4], 0.5F);
}

TEST(PeopleExample, VariedBoxesStayAroundThePerson) {
  const PeoplePicture labels{"x", {{kBox, 1.0}}};
  const Image picture = person_picture(kBox);
  int seen = 0;
  for (std::uint64_t number = 0; number < 40; ++number) {
    RandomStream random(3, {number});
    const PeopleView view = varied_people_view(picture, labels, kWidth, kHeight, random);
    if (view.people.empty()) continue;
    ++seen;
    const Box& box = view.people[0].box;
    // The box is brighter than the rest of the view, unless it is the whole view.
    double inside = 0.0;
    double outside = 0.0;
    int inside_count = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double across = (x + 0.5) / kWidth;
        const double down = (y + 0.5) / kHeight;
        const bool is_inside =
            across > box.x_min && across < box.x_max && down > box.y_min && down < box.y_max;
        const double value = view.planes.values[static_cast<std::size_t>(y) * kWidth + x];
        (is_inside ? inside : outside) += value;
        inside_count += is_inside ? 1 : 0;
      }
    }
    const int outside_count = kWidth * kHeight - inside_count;
    if (inside_count < 8 || outside_count < 8) continue;
    EXPECT_GT(inside / inside_count, outside / outside_count) << number;
  }
  EXPECT_GT(seen, 20);
}

TEST(PeopleExample, TheSameNumberGivesTheSameView) {
  const PeoplePicture labels{"x", {{kBox, 1.0}}};
  const Image picture = person_picture(kBox);
  RandomStream first(1, {5});
  RandomStream again(1, {5});
  RandomStream other(1, {6});
  const auto view = [&](RandomStream& random) {
    return varied_people_view(picture, labels, kWidth, kHeight, random).planes.values;
  };
  const std::vector<float> values = view(first);
  EXPECT_EQ(values, view(again));
  EXPECT_NE(values, view(other));
}

}  // namespace
}  // namespace earpoint
