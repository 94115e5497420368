#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/plot/draw.h>

namespace earpoint {
namespace {

constexpr Color kWhite = {255, 255, 255};
constexpr Color kBlack = {0, 0, 0};

/// The area of black on white, in pixels.
double ink(const Image& image) {
  double sum = 0.0;
  for (const std::uint8_t value : image.pixels()) sum += (255 - value) / 255.0 / 3.0;
  return sum;
}

bool is_white(const Image& image, int x, int y) { return image.at(x, y, 0) == 255; }

TEST(Draw, FillsWholePixelsAndClampsToThePicture) {
  Image image = filled_image(10, 8, kWhite);
  fill_rect(image, {7, 6, 100, 100}, kBlack);
  fill_rect(image, {-5, -5, 6, 6}, kBlack);
  EXPECT_DOUBLE_EQ(ink(image), 3 * 2 + 1);
  EXPECT_FALSE(is_white(image, 7, 6));
  EXPECT_TRUE(is_white(image, 6, 6));
  fill_rect(image, {2, 2, 1, 1}, {55, 155, 255}, 0.5);
  EXPECT_EQ(image.at(2, 2, 0), 155);
  EXPECT_EQ(image.at(2, 2, 1), 205);
  EXPECT_EQ(image.at(2, 2, 2), 255);
}

TEST(Draw, OutlineLiesJustInside) {
  Image image = filled_image(10, 10, kWhite);
  outline_rect(image, {2, 3, 5, 4}, kBlack);
  EXPECT_DOUBLE_EQ(ink(image), 2 * 5 + 2 * 2);
  EXPECT_FALSE(is_white(image, 6, 6));
  EXPECT_TRUE(is_white(image, 3, 4));
}

TEST(Draw, ALineThroughPixelMiddlesFillsExactlyThese) {
  Image image = filled_image(20, 9, kWhite);
  draw_line(image, {2.5, 4.5}, {15.5, 4.5}, kBlack, 1.0);
  for (int x = 3; x < 15; ++x) {
    EXPECT_EQ(image.at(x, 4, 0), 0);
    EXPECT_EQ(image.at(x, 3, 0), 255);
    EXPECT_EQ(image.at(x, 5, 0), 255);
  }
}

TEST(Draw, ALineCoversItsAreaInEveryDirection) {
  for (int degrees = 0; degrees < 180; degrees += 7) {
    for (const double width : {1.0, 2.0, 5.0}) {
      Image image = filled_image(120, 120, kWhite);
      const double angle = degrees * std::numbers::pi / 180.0;
      const double dx = 40.0 * std::cos(angle);
      const double dy = 40.0 * std::sin(angle);
      draw_line(image, {60.2 - dx, 60.7 - dy}, {60.2 + dx, 60.7 + dy}, kBlack, width);
      const double round_ends = std::numbers::pi * width * width / 4.0;
      // Coverage is computed from the distance to the pixel's middle: exact on average over
      // directions, to a few percent in each.
      EXPECT_NEAR(ink(image), 80.0 * width + round_ends, 0.05 * 80.0 * width) << degrees;
    }
  }
}

TEST(Draw, WhereAStrokeMeetsItselfItIsNoDarker) {
  // There and back: grey edges must stay as after one pass.
  Image once = filled_image(30, 30, kWhite);
  Image twice = once;
  const Point a{3.2, 4.1};
  const Point b{25.9, 17.3};
  draw_polyline(once, std::vector<Point>{a, b}, kBlack, 1.3);
  draw_polyline(twice, std::vector<Point>{a, b, a}, kBlack, 1.3);
  EXPECT_TRUE(std::equal(once.pixels().begin(), once.pixels().end(), twice.pixels().begin()));
}

TEST(Draw, WhatLiesOutsideIsLeftOut) {
  Image image = filled_image(8, 8, kWhite);
  draw_line(image, {-100.0, -100.0}, {-5.0, 200.0}, kBlack, 3.0);
  draw_column(image, -1, 0.0, 8.0, kBlack);
  draw_column(image, 8, 0.0, 8.0, kBlack);
  draw_text(image, {100.0, 100.0}, "far away", {});
  paste(image, filled_image(3, 3, kBlack), 20, -20);
  EXPECT_DOUBLE_EQ(ink(image), 0.0);
  draw_line(image, {-1e6, 4.5}, {1e6, 4.5}, kBlack, 1.0);
  EXPECT_DOUBLE_EQ(ink(image), 8.0);
  EXPECT_THROW(draw_line(image, {0.0, NAN}, {1.0, 1.0}, kBlack), std::logic_error);
  Image grey(8, 8, 1);
  EXPECT_THROW(fill_rect(grey, {0, 0, 1, 1}, kBlack), std::logic_error);
}

TEST(Draw, ColumnsHaveAntialiasedEndsAndAreNeverInvisible) {
  Image image = filled_image(3, 10, kWhite);
  draw_column(image, 1, 2.25, 6.5, kBlack);
  // Two ends are rounded to one of 255 steps each.
  EXPECT_NEAR(ink(image), 4.25, 0.01);
  EXPECT_EQ(image.at(1, 2, 0), 64);   // three quarters covered
  EXPECT_EQ(image.at(1, 6, 0), 128);  // half covered
  Image thin = filled_image(3, 10, kWhite);
  draw_column(thin, 1, 5.0, 5.0, kBlack);
  EXPECT_NEAR(ink(thin), 1.0, 0.01);  // rounded, as above
}

TEST(Draw, PasteKeepsPixelsAndCutsAtTheEdges) {
  Image canvas = filled_image(5, 5, kWhite);
  Image patch(3, 3, 3);
  patch.at(0, 0, 1) = 77;
  paste(canvas, patch, 3, 3);
  EXPECT_EQ(canvas.at(3, 3, 1), 77);
  EXPECT_DOUBLE_EQ(std::round(ink(canvas)), 4.0);
  paste(canvas, patch, -2, -2);
  EXPECT_EQ(canvas.at(0, 0, 0), 0);
}

Image picture_of(const std::string& text, const TextStyle& style) {
  Image image = filled_image(200, 60, kWhite);
  draw_text(image, {50.0, 40.0}, text, style);
  return image;
}

TEST(DrawText, EveryAsciiCharacterHasAFormOfItsOwn) {
  std::vector<Image> letters;
  for (char c = '!'; c <= '~'; ++c)
    letters.push_back(picture_of(std::string(1, c), {.size = 30.0}));
  for (std::size_t a = 0; a < letters.size(); ++a) {
    EXPECT_GT(ink(letters[a]), 2.0) << static_cast<char>('!' + a);
    for (std::size_t b = 0; b < a; ++b) {
      double difference = 0.0;
      for (std::size_t i = 0; i < letters[a].pixels().size(); ++i) {
        difference += std::abs(letters[a].pixels()[i] - letters[b].pixels()[i]) / 255.0 / 3.0;
      }
      EXPECT_GT(difference, 3.0) << static_cast<char>('!' + a) << static_cast<char>('!' + b);
    }
  }
  EXPECT_DOUBLE_EQ(ink(picture_of(" ", {.size = 30.0})), 0.0);
}

TEST(DrawText, WhatIsNotAsciiBecomesAQuestionMark) {
  const Image expected = picture_of("a?b", {});
  const Image image = picture_of(
      "a\x07"
      "b",
      {});
  EXPECT_TRUE(std::equal(image.pixels().begin(), image.pixels().end(), expected.pixels().begin()));
  EXPECT_GT(ink(picture_of("\xc3\xa4", {})), 0.0);
}

/// First and last column with ink.
std::pair<int, int> extent(const Image& image) {
  int first = image.width();
  int last = -1;
  for (int x = 0; x < image.width(); ++x) {
    for (int y = 0; y < image.height(); ++y) {
      if (is_white(image, x, y)) continue;
      first = std::min(first, x);
      last = std::max(last, x);
    }
  }
  return {first, last};
}

TEST(DrawText, WidthAndAlignmentTellWhereTheInkIs) {
  for (const double size : {9.0, 14.0, 33.0}) {
    const double width = text_width("Hm", {.size = size});
    EXPECT_GT(width, 0.9 * size);
    for (const auto& [align, left] :
         {std::pair{TextAlign::left, 50.0}, std::pair{TextAlign::centre, 50.0 - width / 2.0},
          std::pair{TextAlign::right, 50.0 - width}}) {
      const auto [first, last] = extent(picture_of("Hm", {.size = size, .align = align}));
      // Half a stroke and an antialiased edge are outside the letters' centre lines.
      const double margin = 1.5 + 0.05 * size;
      EXPECT_NEAR(first, left, margin) << size;
      EXPECT_NEAR(last, left + width, margin) << size;
    }
  }
  EXPECT_EQ(text_width("", {}), 0.0);
  EXPECT_DOUBLE_EQ(text_width("17", {}), text_width("40", {})) << "figures align in columns";
}

TEST(DrawText, CapitalsStandOnTheBaselineAtTheirHeight) {
  const Image image = picture_of("H", {.size = 30.0});
  int top = image.height();
  int bottom = -1;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (is_white(image, x, y)) continue;
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  // The last pixel is the one above the line, and edges are blended over one more.
  EXPECT_NEAR(bottom, 40, 2);
  EXPECT_NEAR(top, 40 - 0.7 * 30, 2);
  EXPECT_GT(ink(picture_of("H", {.size = 30.0, .is_bold = true})), 1.3 * ink(image));
}

}  // namespace
}  // namespace earpoint
