#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/network/network_kind.h>
#include <earpoint/network_testing/refusal.h>
#include <earpoint/people/description.h>
#include <earpoint/people/view.h>
#include <earpoint/people/weights.h>

namespace earpoint {
namespace {

TEST(PeopleDescription, JsonRoundTrips) {
  const PeopleDescription read =
      people_description_from_json(to_json(PeopleDescription{320, 8}), "x");
  EXPECT_EQ(read.longest_px, 320);
  EXPECT_EQ(read.channels, 8);
}

TEST(PeopleDescription, WrongValuesAreNamed) {
  const auto said = [](const std::string& rest) {
    return refusal([&] {
      (void)people_description_from_json(R"({"format":1,"network":"people",)" + rest, "x");
    });
  };
  EXPECT_EQ(said(R"("longest_px":256,"channels":16})"), "accepted");
  EXPECT_NE(said(R"("longest_px":250,"channels":16})").find("multiple of 32, found 250"),
            std::string::npos);
  EXPECT_NE(said(R"("longest_px":256,"channels":0})").find("channels"), std::string::npos);
  EXPECT_NE(said(R"("longest_px":256,"channels":16,"depth":3})").find("depth"), std::string::npos);
}

TEST(PeopleWeights, WeightFileReadsBack) {
  PeopleWeights weights{{64, 2}, {}, {}};
  for (const auto& [name, shape] : required_tensors(weights.description)) {
    const std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()), 0.5F);
    weights.tensors[name] = make_tensor<float>(values, shape);
  }
  const SafetensorsFile file = to_weight_file(weights, {{"note", "of a test"}});
  EXPECT_EQ(network_kind(file, "x"), NetworkKind::people);
  const PeopleWeights read = people_weights(file, "x");
  EXPECT_EQ(read.description.channels, 2);
  EXPECT_EQ(read.tensors, weights.tensors);
}

TEST(PeopleView, KeepsTheProportionsToTheNearestMultipleOf32) {
  const ImagePlanes wide = people_view(Image(640, 360, 3), 256);
  EXPECT_EQ(wide.width, 256);
  EXPECT_EQ(wide.height, 160);  // 144 lies in the middle of 128 and 160
  const ImagePlanes upright = people_view(Image(90, 160, 3), 256);
  EXPECT_EQ(upright.width, 160);
  EXPECT_EQ(upright.height, 256);
}

TEST(PeopleView, AveragesOverEachPixelsArea) {
  Image picture(128, 128, 3);
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) picture.at(x, y, 1) = (x + y) % 2 == 0 ? 255 : 0;
  }
  const ImagePlanes view = people_view(picture, 64);
  ASSERT_EQ(view.values.size(), 3U * 64 * 64);
  // A checkerboard's mean is one half; 1e-6 is float32's rounding.
  EXPECT_NEAR(view.values[64 * 64 + 5], 0.0F, 1e-6);
  EXPECT_EQ(view.values[0], -0.5F);
}

TEST(PeopleView, OfAPartShowsThatPart) {
  Image picture(64, 64, 3);
  for (int y = 0; y < 64; ++y) {
    for (int x = 32; x < 64; ++x) picture.at(x, y, 0) = 255;
  }
  const Box right{.x_min = 0.5, .y_min = 0.0, .x_max = 1.0, .y_max = 0.5};
  for (const float value : people_view_of_part(picture, right, 32, 32).values) {
    EXPECT_EQ(std::abs(value), 0.5F);
  }
  EXPECT_EQ(people_view_of_part(picture, right, 32, 32).values[0], 0.5F);
}

}  // namespace
}  // namespace earpoint
