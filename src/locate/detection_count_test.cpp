#include <vector>

#include <gtest/gtest.h>

#include <earpoint/locate/detection_count.h>

namespace earpoint {
namespace {

Box at(double x) { return {.x_min = x, .y_min = 0.0, .x_max = x + 0.2, .y_max = 0.5}; }

TEST(CountDetections, CountsFoundMissedAndWrong) {
  const std::vector<TruePerson> people{{at(0.1)}, {at(0.5)}};
  const std::vector<DetectedPerson> found{{at(0.12), 0.9}, {at(0.75), 0.8}};
  const DetectionCount count = count_detections(found, people);
  EXPECT_EQ(count.found, 1);
  EXPECT_EQ(count.missed, 1);
  EXPECT_EQ(count.wrong, 1);
  EXPECT_EQ(count.recall(), 0.5);
  EXPECT_EQ(count.precision(), 0.5);
}

TEST(CountDetections, NobodyIsFoundTwice) {
  const std::vector<TruePerson> people{{at(0.1)}};
  const std::vector<DetectedPerson> found{{at(0.1), 0.9}, {at(0.11), 0.8}};
  const DetectionCount count = count_detections(found, people);
  EXPECT_EQ(count.found, 1);
  EXPECT_EQ(count.wrong, 1);
}

TEST(CountDetections, WhoNeedNotBeFoundCountsForNothing) {
  const std::vector<TruePerson> people{{at(0.1), false}, {at(0.6), false}, {at(0.62), true}};
  const std::vector<DetectedPerson> found{{at(0.1), 0.9}, {at(0.6), 0.8}};
  const DetectionCount count = count_detections(found, people);
  EXPECT_EQ(count.found, 1);  // a person who must be found comes before a nearer one who need not
  EXPECT_EQ(count.missed, 0);
  EXPECT_EQ(count.wrong, 0);
}

TEST(CountDetections, OfNothingIsPerfect) {
  const DetectionCount none = count_detections({}, {});
  EXPECT_EQ(none.recall(), 1.0);
  EXPECT_EQ(none.precision(), 1.0);
}

}  // namespace
}  // namespace earpoint
