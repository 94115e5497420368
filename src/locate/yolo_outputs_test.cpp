#include "yolo_outputs.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace earpoint {
namespace {

constexpr int kPlaces = 64 + 16 + 4;  // of 64 x 64 pixels

TEST(YoloOutputs, CountsThePlacesOfThreeGrids) {
  EXPECT_EQ(yolo_places(64, 64), kPlaces);
  EXPECT_EQ(yolo_places(640, 640), 8400);
  EXPECT_EQ(yolo_places(416, 416), 3549);
}

TEST(YoloOutputs, YoloV8HasMiddleAndSizeInPixels) {
  std::vector<float> output(std::size_t{6} * kPlaces, 0.0F);
  const std::vector<float> numbers{20, 30, 8, 10, 0.6F, 0.9F};
  for (std::size_t row = 0; row < 6; ++row) output[row * kPlaces + 70] = numbers[row];
  output[5 * kPlaces + 3] = 0.9F;  // something that is no person
  const auto people = yolo_people(output, YoloLayout::yolov8, kPlaces, 64, 64, 0.5);
  ASSERT_EQ(people.size(), 1U);
  EXPECT_EQ(people[0].box, (Box{.x_min = 16, .y_min = 25, .x_max = 24, .y_max = 35}));
  EXPECT_FLOAT_EQ(static_cast<float>(people[0].score), 0.6F);
}

TEST(YoloOutputs, YoloXCountsFromThePlaceInSteps) {
  std::vector<float> output(std::size_t{7} * kPlaces, 0.0F);
  // The second grid's second row, third column: steps of 16 pixels.
  float* place = output.data() + (64 + 4 + 2) * 7;
  place[0] = 0.5F;
  place[1] = 0.25F;
  place[2] = std::log(2.0F);
  place[3] = 0.0F;
  place[4] = 0.8F;
  place[5] = 0.75F;
  const auto people = yolo_people(output, YoloLayout::yolox, kPlaces, 64, 64, 0.5);
  ASSERT_EQ(people.size(), 1U);
  // Middle (40, 20), 32 wide, 16 high; float32's rounding of the logarithm.
  EXPECT_NEAR(people[0].box.x_min, 24, 1e-5);
  EXPECT_NEAR(people[0].box.x_max, 56, 1e-5);
  EXPECT_NEAR(people[0].box.y_min, 12, 1e-5);
  EXPECT_NEAR(people[0].box.y_max, 28, 1e-5);
  EXPECT_NEAR(people[0].score, 0.6, 1e-6);
}

TEST(YoloOutputs, WhatIsNoNumberIsNoPerson) {
  std::vector<float> output(std::size_t{6} * kPlaces, std::nanf(""));
  EXPECT_TRUE(yolo_people(output, YoloLayout::yolov8, kPlaces, 64, 64, 0.0).empty());
}

}  // namespace
}  // namespace earpoint
