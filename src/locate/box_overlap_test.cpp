#include <gtest/gtest.h>

#include <earpoint/locate/box_overlap.h>

namespace earpoint {
namespace {

TEST(IntersectionOverUnion, IsTheSharedPartOfWhatBothCover) {
  const Box box{.x_min = 0.0, .y_min = 0.0, .x_max = 0.5, .y_max = 0.5};
  const Box beside{.x_min = 0.25, .y_min = 0.0, .x_max = 0.75, .y_max = 0.5};
  EXPECT_DOUBLE_EQ(intersection_over_union(box, box), 1.0);
  EXPECT_DOUBLE_EQ(intersection_over_union(box, beside), 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(intersection_over_union(beside, box), 1.0 / 3.0);
}

TEST(IntersectionOverUnion, IsZeroForBoxesApartAndForBoxesWithoutArea) {
  const Box box{.x_min = 0.0, .y_min = 0.0, .x_max = 0.4, .y_max = 0.4};
  EXPECT_EQ(intersection_over_union(box, {.x_min = 0.5, .y_min = 0.5, .x_max = 0.9, .y_max = 0.9}),
            0.0);
  EXPECT_EQ(intersection_over_union({}, {}), 0.0);
}

TEST(SuppressRepeated, KeepsTheSurestOfEveryPersonAndOrdersThem) {
  const auto at = [](double x, double score) {
    return DetectedPerson{{.x_min = x, .y_min = 0.0, .x_max = x + 0.2, .y_max = 0.5}, score};
  };
  const auto kept = suppress_repeated({at(0.1, 0.4), at(0.6, 0.9), at(0.12, 0.8)}, 0.5);
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0].score, 0.9);
  EXPECT_EQ(kept[1].score, 0.8);
}

}  // namespace
}  // namespace earpoint
