#include <gtest/gtest.h>

#include <earpoint/core/resize.h>

namespace earpoint {
namespace {

TEST(ResizeBilinear, ALinearRampStaysLinearBetweenItsOuterPixels) {
  ImagePlanes ramp{1, 1, 8, {0, 1, 2, 3, 4, 5, 6, 7}};
  const ImagePlanes larger = resize_bilinear(ramp, 16, 1);
  // Half-pixel centres: output i lies at (i + 0.5) / 2 - 0.5, held at the two ends.
  EXPECT_FLOAT_EQ(larger.values[0], 0.0F);
  EXPECT_FLOAT_EQ(larger.values[1], 0.25F);
  EXPECT_FLOAT_EQ(larger.values[14], 6.75F);
  EXPECT_FLOAT_EQ(larger.values[15], 7.0F);
}

TEST(ResizeBilinear, ShrinkingTakesTwoNeighboursAndDoesNotSmooth) {
  ImagePlanes spike{1, 8, 1, {0, 0, 0, 0, 80, 0, 0, 0}};
  // Outputs are at 1.5 and 5.5, between pixels 1 and 2, and 5 and 6: the spike has no effect.
  EXPECT_EQ(resize_bilinear(spike, 1, 2).values, (std::vector<float>{0, 0}));
}

TEST(ResizeBilinear, PlanesAndRowsKeepTheirPlaces) {
  Image image(2, 2, 3);
  image.at(1, 0, 2) = 200;
  const ImagePlanes planes = planes_of(image);
  EXPECT_EQ(planes.values[2 * 4 + 0 * 2 + 1], 200.0F);
  const ImagePlanes larger = resize_bilinear(planes, 4, 4);
  EXPECT_FLOAT_EQ(larger.values[2 * 16 + 0 * 4 + 3], 200.0F);
  EXPECT_FLOAT_EQ(larger.values[2 * 16 + 3 * 4 + 0], 0.0F);
}

}  // namespace
}  // namespace earpoint
