#include "texture.h"

#include <gtest/gtest.h>

namespace earpoint {
namespace {

// Two rows, the upper black and the lower white; the left column red where white.
Image four_pixels() {
  Image image(2, 2, 3);
  image.at(0, 1, 0) = 255;
  for (int c = 0; c < 3; ++c) image.at(1, 1, c) = 255;
  return image;
}

TEST(Texture, HasItsFirstRowOnTopAndVPointsUp) {
  const Texture texture(four_pixels());
  const Rgb lower_left = texture.sample(0.25F, 0.25F, 0.0F);
  EXPECT_EQ(lower_left.x, 1.0F);
  EXPECT_EQ(lower_left.y, 0.0F);
  EXPECT_EQ(texture.sample(0.25F, 0.75F, 0.0F).x, 0.0F);
  EXPECT_EQ(texture.sample(0.75F, 0.25F, 0.0F).y, 1.0F);
}

TEST(Texture, IsLinearBetweenPixels) {
  const Texture texture(four_pixels());
  // Half-way between the two lower pixels, and a quarter off their row towards the upper one.
  EXPECT_FLOAT_EQ(texture.sample(0.5F, 0.25F, 0.0F).y, 0.5F);
  EXPECT_FLOAT_EQ(texture.sample(0.25F, 0.375F, 0.0F).x, 0.75F);
}

TEST(Texture, Repeats) {
  const Texture texture(four_pixels());
  for (const float shift : {-3.0F, 1.0F, 7.0F}) {
    // Rounding of coordinates up to 7.3 in single precision.
    EXPECT_NEAR(texture.sample(0.3F + shift, 0.2F - shift, 0.0F).x,
                texture.sample(0.3F, 0.2F, 0.0F).x, 1e-5F);
  }
  // Across the border: half of the pixel on either side.
  EXPECT_FLOAT_EQ(texture.sample(0.0F, 0.25F, 0.0F).y, 0.5F);
}

TEST(Texture, ShowsItsMeanFromFarAway) {
  const Texture texture(four_pixels());
  // Light adds linearly: red is on in half of the pixels, green in a quarter. 8 bits of sRGB are
  // steps of 0.4 %.
  EXPECT_NEAR(texture.mean().x, 0.5F, 0.005F);
  EXPECT_NEAR(texture.mean().y, 0.25F, 0.005F);
  EXPECT_EQ(texture.sample(0.1F, 0.9F, 2.0F).x, texture.mean().x);
  EXPECT_EQ(texture.sample(0.1F, 0.9F, 1e9F).x, texture.mean().x);
}

TEST(Texture, TakesSizesThatAreNoPowersOfTwo) {
  Image image(5, 3, 3, 128);
  const Texture texture(image);
  for (const float width : {0.0F, 1.5F, 3.0F, 6.0F}) {
    EXPECT_NEAR(texture.sample(0.77F, 0.31F, width).y, linear_from_srgb(128), 1e-6F);
  }
}

TEST(Srgb, GoesThereAndBack) {
  for (int value = 0; value < 256; ++value) {
    const auto byte = static_cast<std::uint8_t>(value);
    EXPECT_EQ(srgb_from_linear(linear_from_srgb(byte)), byte);
  }
  EXPECT_EQ(srgb_from_linear(2.0F), 255);
  EXPECT_EQ(srgb_from_linear(-1.0F), 0);
  // IEC 61966-2-1: a linear 0.5 is 188 (187.5).
  EXPECT_EQ(srgb_from_linear(0.5F), 188);
}

}  // namespace
}  // namespace earpoint
