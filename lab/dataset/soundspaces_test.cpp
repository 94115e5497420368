#include <filesystem>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/dataset/soundspaces.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

TEST(SoundSpacesFrame, AheadAndLeftBecomeOurs) {
  // At rotation 0 a viewpoint looks along -z, and -x lies to its left.
  EXPECT_EQ(from_soundspaces({0, 0, -1}), (Vector3{1, 0, 0}));
  EXPECT_EQ(from_soundspaces({-1, 0, 0}), (Vector3{0, 1, 0}));
  EXPECT_EQ(from_soundspaces({0, 1.5, 0}), (Vector3{0, 0, 1.5}));
  const Vector3 v{1, -2, 3};
  EXPECT_EQ(from_soundspaces(to_soundspaces(v)), v);
}

TEST(SoundSpacesFrame, APoseAheadHasAzimuthZeroAndLeftIsPositive) {
  SoundSpacesViewpoint from;
  from.rotation_rad = kPi / 2;  // turned to the left: looks along -x
  const auto ahead = soundspaces_pose(from, {-2, 0, 0});
  EXPECT_NEAR(ahead[0], 2.0, 1e-12);
  EXPECT_NEAR(ahead[1], 0.0, 1e-12);
  EXPECT_NEAR(ahead[2], 1.0, 1e-12);
  const auto left = soundspaces_pose(from, {0, 0, 2});
  EXPECT_NEAR(left[1], 1.0, 1e-12);
}

class SoundSpacesMetadataTest : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) /
            (std::string("soundspaces_metadata_") +
             testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(root_);
  }
  void TearDown() override { fs::remove_all(root_); }

  [[nodiscard]] std::string error_of(const std::string& metadata) const {
    const fs::path scene = root_ / "data/synthetic_dataset/v16/test/home";
    fs::create_directories(scene);
    write_file(scene / "cleaned_metadata_v3.json", metadata);
    try {
      const SoundSpacesDataset dataset({.root = root_});
    } catch (const InputError& error) {
      std::string message = error.what();
      return message.substr(message.find("cleaned_metadata_v3.json"));
    }
    return "no error";
  }

  fs::path root_;
};

TEST_F(SoundSpacesMetadataTest, ErrorsNameTheField) {
  EXPECT_EQ(error_of("["), "cleaned_metadata_v3.json: is not valid JSON");
  EXPECT_EQ(error_of("{}"), "cleaned_metadata_v3.json: expected a list, found {}");
  EXPECT_EQ(error_of("[{}]"), "cleaned_metadata_v3.json: [0]: the field 'viewpoints' is missing");
  EXPECT_EQ(error_of(R"([{"viewpoints": [{"location": [1, 2]}]}])"),
            "cleaned_metadata_v3.json: [0].viewpoints[0].location: expected three numbers, found "
            "[1,2]");
}

TEST_F(SoundSpacesMetadataTest, AMissingSplitIsNamed) {
  EXPECT_THROW(SoundSpacesDataset({.root = root_, .split = "nowhere"}), InputError);
}

}  // namespace
}  // namespace earpoint
