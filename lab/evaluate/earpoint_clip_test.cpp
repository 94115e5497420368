#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/earpoint_clip.h>
#include <earpoint/media/image_file.h>
#include <earpoint/media/media.h>

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
  // Turned by 90 degrees the head looks to the left, along y. Rounding of doubles.
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
  EXPECT_NE(refusal(R"({"earpoints": []})").find("the field 'clip' is missing"), std::string::npos);
  EXPECT_NE(refusal(R"({"clip": "gone.wav", "earpoints": []})").find("gone.wav does not exist"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"clip": "clip.wav", "earpoints": []})").find("at least one earpoint"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"clip": "clip.wav", "speker": [1, 2, 3], "earpoints": [)" + one + "]}")
                .find("speker: is not known"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"clip": "clip.wav", "earpoints": [)" + one + "," + one + "]}")
                .find("earpoints[1]: is called 'left' like one before"),
            std::string::npos);
  EXPECT_NE(refusal(R"({"clip": "clip.wav", "earpoints": [{"name": "left", "translate": [1, 2],
      "yaw_deg": 0, "truth": "truth.wav"}]})")
                .find("earpoints[0].translate: expected 3 numbers"),
            std::string::npos);
}

/// Energy of an ear in decibels.
double level_db(const Waveform& sound, int ear) {
  double energy = 0.0;
  for (const float sample : sound.channel(ear)) energy += double{sample} * sample;
  return 10.0 * std::log10(energy);
}

class BundledClip : public testing::Test {
 protected:
  [[nodiscard]] Waveform truth(const std::string& name) const {
    const auto found = std::ranges::find(clip_.earpoints, name, &KnownEarpoint::name);
    if (found == clip_.earpoints.end())
      throw InputError("examples/earpoints.json", "lacks " + name);
    return read_sound(found->truth);
  }
  [[nodiscard]] double left_less_right_db(const std::string& name) const {
    const Waveform sound = truth(name);
    return level_db(sound, 0) - level_db(sound, 1);
  }
  [[nodiscard]] double loudness_db(const std::string& name) const {
    const Waveform sound = truth(name);
    return std::max(level_db(sound, 0), level_db(sound, 1));
  }

  EarpointClip clip_ = read_earpoint_clip(EARPOINT_SOURCE_DIR "/examples/earpoints.json");
};

TEST_F(BundledClip, TruthsAreBinauralAndAsLongAsTheClip) {
  const double clip_s = probe_media(clip_.clip).duration_s.value();
  ASSERT_EQ(clip_.earpoints.size(), 4U);
  for (const KnownEarpoint& earpoint : clip_.earpoints) {
    const Waveform sound = read_sound(earpoint.truth);
    EXPECT_EQ(sound.channels(), 2) << earpoint.name;
    // A frame of AAC at 48 kHz lasts 21 ms.
    EXPECT_NEAR(sound.duration_s(), clip_s, 0.022) << earpoint.name;
  }
}

// Most energy of speech is at frequencies where the head shadows little: without a room the ears
// differ by 5 to 6 dB with the speaker at the side.
TEST_F(BundledClip, TheNearerEarHearsTheSpeakerLouder) {
  EXPECT_GT(left_less_right_db("speaker on the left"), 4.0);
  EXPECT_LT(left_less_right_db("speaker on the right"), -4.0);
}

// 6 dB is half the sound pressure, which is clearly audible.
TEST_F(BundledClip, FarAwayIsQuieterAndTheNextRoomStillMore) {
  const double near_db = loudness_db("speaker on the left");
  const double far_db = loudness_db("far away");
  EXPECT_LT(far_db, near_db - 6.0);
  EXPECT_LT(loudness_db("in the next room"), far_db - 6.0);
}

TEST_F(BundledClip, MapAndSpeakerAreThere) {
  ASSERT_TRUE(clip_.map);
  const Image map = read_image(clip_.map->picture);
  for (const KnownEarpoint& earpoint : clip_.earpoints) {
    const Vector3& at = earpoint.source_from_target.position_m;
    const double x = clip_.map->camera_x - at.y * clip_.map->pixels_per_metre;
    const double y = clip_.map->camera_y - at.x * clip_.map->pixels_per_metre;
    EXPECT_TRUE(x > 0.0 && x < map.width() && y > 0.0 && y < map.height()) << earpoint.name;
  }
  ASSERT_TRUE(clip_.speaker_m && clip_.speaker_box);
  // The picture spans 90 degrees: the mouth lies within the box.
  const double column = 0.5 - 0.5 * clip_.speaker_m->y / clip_.speaker_m->x;
  EXPECT_GT(column, clip_.speaker_box->x_min);
  EXPECT_LT(column, clip_.speaker_box->x_max);
}

}  // namespace
}  // namespace earpoint
