#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include <earpoint/camera/view.h>

namespace earpoint {
namespace {

View view_of(int width, int height) {
  View view;
  view.instance = Raster<std::int32_t>(width, height, 1, View::kNoInstance);
  return view;
}

TEST(VisibleBox, CoversThePixelsToTheirOuterEdges) {
  View view = view_of(8, 4);
  view.instance.at(2, 1) = 5;
  view.instance.at(4, 2) = 5;
  view.instance.at(6, 3) = 1;
  EXPECT_EQ(visible_box(view, 5, 1), (Box{2.0 / 8, 1.0 / 4, 5.0 / 8, 3.0 / 4}));
  EXPECT_EQ(visible_box(view, 1, 1), (Box{6.0 / 8, 3.0 / 4, 7.0 / 8, 4.0 / 4}));
}

TEST(VisibleBox, IsNothingForTooFewPixels) {
  View view = view_of(8, 4);
  view.instance.at(2, 1) = 5;
  view.instance.at(3, 1) = 5;
  EXPECT_TRUE(visible_box(view, 5, 2));
  EXPECT_FALSE(visible_box(view, 5, 3));
  EXPECT_FALSE(visible_box(view, 4, 1));
  EXPECT_THROW(static_cast<void>(visible_box(view, 5, 0)), std::logic_error);
}

TEST(PictureOfDepth, GoesFromWhiteToBlack) {
  FloatImage depth(4, 1, 1);
  depth.at(1, 0) = 5.0F;
  depth.at(2, 0) = 10.0F;
  depth.at(3, 0) = std::numeric_limits<float>::infinity();
  const Image picture = picture_of_depth(depth, 10.0);
  EXPECT_EQ(picture.channels(), 1);
  EXPECT_EQ(picture.at(0, 0), 255);
  EXPECT_EQ(picture.at(1, 0), 128);  // 127.5 rounds away from zero
  EXPECT_EQ(picture.at(2, 0), 0);
  EXPECT_EQ(picture.at(3, 0), 0);
}

TEST(PictureOfInstances, GivesEachItsOwnColourAndNoneBlack) {
  Raster<std::int32_t> instance(40, 1, 1);
  for (int x = 0; x < 40; ++x) instance.at(x, 0) = x - 1;
  const Image picture = picture_of_instances(instance);
  EXPECT_EQ(picture.at(0, 0, 0) + picture.at(0, 0, 1) + picture.at(0, 0, 2), 0);
  for (int a = 1; a < 40; ++a) {
    for (int b = 0; b < a; ++b) {
      const bool same = picture.at(a, 0, 0) == picture.at(b, 0, 0) &&
                        picture.at(a, 0, 1) == picture.at(b, 0, 1) &&
                        picture.at(a, 0, 2) == picture.at(b, 0, 2);
      EXPECT_FALSE(same) << a << " and " << b;
    }
  }
}

}  // namespace
}  // namespace earpoint
