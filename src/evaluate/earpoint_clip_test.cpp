#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/error.h>
#include <earpoint/core/file.h>
#include <earpoint/evaluate/earpoint_clip.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class EarpointClipTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::create_directories(folder_);
    for (const char* name : {"clip.wav", "truth.wav", "map.png"}) write_file(folder_ / name, "");
  }
  void TearDown() override { fs::remove_all(folder_); }

  EarpointClip read(const std::string& text) {
    write_file(folder_ / "clip.json", text);
    return read_earpoint_clip(folder_ / "clip.json");
  }

  std::string refusal(const std::string& text) {
    try {
      (void)read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }

  fs::path folder_;
};

constexpr const char* kEarpoint =
    R"({"name": "left", "translate": [1, -0.5, 0], "yaw_deg": 90, "truth": "truth.wav"})";

TEST_F(EarpointClipTest, ReadsWhatIsKnown) {
  const EarpointClip clip = read(std::string(R"({"clip": "clip.wav", "speaker": [2, 0.5, -0.1],
      "speaker_box": [0.4, 0.2, 0.6, 0.9], "fov_deg": 70,
      "map": {"picture": "map.png", "camera": [10, 20], "pixels_per_metre": 80},
      "earpoints": [)") + kEarpoint +
                                 "]}");
  EXPECT_EQ(clip.clip, folder_ / "clip.wav");
  EXPECT_EQ(clip.speaker_m, (Vector3{2.0, 0.5, -0.1}));
  EXPECT_EQ(clip.speaker_box, (Box{0.4, 0.2, 0.6, 0.9}));
  EXPECT_EQ(clip.fov_deg, 70.0);
  ASSERT_TRUE(clip.map);
  EXPECT_EQ(clip.map->camera_y, 20.0);
  ASSERT_EQ(clip.earpoints.size(), 1U);
  EXPECT_EQ(clip.earpoints[0].truth, folder_ / "truth.wav");
  EXPECT_EQ(clip.earpoints[0].source_from_target.position_m, (Vector3{1.0, -0.5, 0.0}));
  // Turned by 90 degrees one looks to the left: along y. Rounding of doubles.
  EXPECT_NEAR(rotate(clip.earpoints[0].source_from_target.orientation, {1, 0, 0}).y, 1.0, 1e-12);
}

TEST_F(EarpointClipTest, KnowsNoMoreThanItIsTold) {
  const EarpointClip clip =
      read(std::string(R"({"clip": "clip.wav", "earpoints": [)") + kEarpoint + "]}");
  EXPECT_FALSE(clip.speaker_m || clip.speaker_box || clip.fov_deg || clip.map);
}

TEST_F(EarpointClipTest, RefusalsNameTheField) {
  const std::string one = kEarpoint;
  EXPECT_NE(refusal("{").find("is not valid JSON"), std::string::npos);
  EXPECT_NE(refusal(R"({"earpoints": []})").find("lacks 'clip'"), std::string::npos);
  EXPECT_NE(refusal(R"({"clip": "gone.wav", "earpoints": []})").find("gone.wav is not there"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"clip": "clip.wav", "earpoints": []})").find("at least one earpoint"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"clip": "clip.wav", "speker": [1, 2, 3], "earpoints": [)" + one + "]}")
                .find("unknown field 'speker'"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"clip": "clip.wav", "earpoints": [)" + one + "," + one + "]}")
                .find("earpoint 2: is called 'left' like one before"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"clip": "clip.wav", "earpoints": [{"name": "left", "translate": [1, 2],
      "yaw_deg": 0, "truth": "truth.wav"}]})")
                .find("earpoint 1: translate: expected 3 numbers"),
            std::string::npos);
}

}  // namespace
}  // namespace earpoint
