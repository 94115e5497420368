#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/gtf/view.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kRightAngle = 0.5 * kPi;
// Sums of float32 shares.
constexpr float kRounding = 1e-5F;

/// Red grows to the right, green downwards; blue is full.
Image gradients(int width, int height) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at(x, y, 0) = static_cast<std::uint8_t>(x);
      image.at(x, y, 1) = static_cast<std::uint8_t>(y);
      image.at(x, y, 2) = 255;
    }
  }
  return image;
}

float at(const GtfView& view, int size, int channel, int y, int x) {
  return view.picture[(static_cast<std::size_t>(channel) * size + y) * size + x];
}

TEST(GtfView, AveragesWholePixelsOfASquareCameraOfNinetyDegrees) {
  const Image image = gradients(32, 32);
  const GtfView view = gtf_view(&image, Box{0.1, 0.2, 0.3, 0.4}, kRightAngle, 8);
  EXPECT_NEAR(at(view, 8, 0, 3, 2), (8 + 9 + 10 + 11) / 4.0F / 255.0F, kRounding);
  EXPECT_NEAR(at(view, 8, 1, 3, 2), (12 + 13 + 14 + 15) / 4.0F / 255.0F, kRounding);
  EXPECT_NEAR(at(view, 8, 2, 0, 0), 1.0F, kRounding);
  ASSERT_TRUE(view.speaker_box);
  EXPECT_NEAR(view.speaker_box->x_min, 0.1, 1e-12);
  EXPECT_NEAR(view.speaker_box->y_max, 0.4, 1e-12);
}

TEST(GtfView, KeepsAMeanWhenSizesDoNotDivide) {
  const Image image = gradients(30, 30);
  const GtfView view = gtf_view(&image, {}, kRightAngle, 8);
  float sum = 0.0F;
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) sum += at(view, 8, 0, y, x);
  }
  EXPECT_NEAR(sum / 64.0F, 14.5F / 255.0F, kRounding);
  EXPECT_FALSE(view.speaker_box);
}

TEST(GtfView, IsGreyWhereANarrowOrWideCameraSawNothing) {
  const Image image = gradients(32, 16);
  const GtfView wide = gtf_view(&image, {}, kRightAngle, 8);
  EXPECT_EQ(at(wide, 8, 2, 1, 4), 0.5F);
  EXPECT_NEAR(at(wide, 8, 2, 2, 4), 1.0F, kRounding);
  // The tangent is half as wide: the picture fills the middle half of the view.
  const GtfView narrow = gtf_view(&image, Box{0.0, 0.0, 1.0, 1.0}, 2.0 * std::atan(0.5), 8);
  EXPECT_EQ(at(narrow, 8, 2, 4, 1), 0.5F);
  EXPECT_NEAR(at(narrow, 8, 2, 4, 2), 1.0F, kRounding);
  ASSERT_TRUE(narrow.speaker_box);
  EXPECT_NEAR(narrow.speaker_box->x_min, 0.25, 1e-12);
  EXPECT_NEAR(narrow.speaker_box->y_min, 0.375, 1e-12);
}

TEST(GtfView, HasNoBoxOutOfItsSight) {
  const Image image = gradients(32, 32);
  // Twice the tangent: the view shows the middle half.
  EXPECT_FALSE(gtf_view(&image, Box{0.0, 0.4, 0.2, 0.6}, 2.0 * std::atan(2.0), 8).speaker_box);
  EXPECT_TRUE(gtf_view(&image, Box{0.0, 0.4, 0.3, 0.6}, 2.0 * std::atan(2.0), 8).speaker_box);
}

TEST(GtfView, IsGreyWithoutAPicture) {
  const GtfView view = gtf_view(nullptr, Box{0.1, 0.2, 0.3, 0.4}, kRightAngle, 4);
  EXPECT_EQ(view.picture, std::vector<float>(3 * 4 * 4, 0.5F));
  EXPECT_TRUE(view.speaker_box);
}

}  // namespace
}  // namespace earpoint
