#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/earpoint_comparison.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr int kRate_hz = 16000;

/// Noise that is the same in both ears except for their gains.
Waveform noise(float left, float right, double duration_s = 1.0) {
  RandomStream random(1);
  Waveform sound(2, std::lround(duration_s * kRate_hz), kRate_hz);
  for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
    const auto sample = static_cast<float>(0.1 * random.normal());
    sound.channel(0)[i] = left * sample;
    sound.channel(1)[i] = right * sample;
  }
  return sound;
}

class EarpointComparisonTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::create_directories(folder_ / "out");
    write_sound(folder_ / "clip.wav", noise(0.5F, 0.5F));
  }
  void TearDown() override { fs::remove_all(folder_); }

  EarpointComparison compare(const Waveform& truth) {
    write_sound(folder_ / "truth.wav", truth);
    const EarpointClip clip{
        .description = folder_ / "clip.json",
        .clip = folder_ / "clip.wav",
        .speaker_m = Vector3{2.0, 0.0, 0.0},
        .speaker_box = {},
        .fov_deg = {},
        .map = {},
        .earpoints = {{"Near, to the left", Pose{}, 0.0, folder_ / "truth.wav"}}};
    const std::vector<ClipMethod> methods{{"input", "input"}, {"dsp", "dsp"}};
    SilentProgress progress;
    return compare_earpoints(clip, methods, folder_ / "out", {}, progress);
  }

  fs::path folder_;
};

TEST_F(EarpointComparisonTest, TellsLevelsAndWhatACopyMisses) {
  // 6.02 dB louder at the left ear, 6.02 dB softer at the right.
  const EarpointComparison comparison = compare(noise(1.0F, 0.25F));
  ASSERT_EQ(comparison.earpoints.size(), 1U);
  const EarpointResult& result = comparison.earpoints[0];
  // Closed forms: 10 log10 of (1 + 1/16) / (1/4 + 1/4), and 20 log10 of 4, to three digits.
  EXPECT_NEAR(result.truth.level_db, 3.274, 0.001);
  EXPECT_NEAR(result.truth.left_right_db, 12.041, 0.001);
  const RenderedEarpoint& copy = result.renderings[0];
  EXPECT_NEAR(copy.levels.level_db, 0.0, 0.001);
  EXPECT_NEAR(*copy.metrics[Metric::lre], 12.041, 0.001);
  EXPECT_NEAR(*copy.metrics[Metric::level], 6.021, 0.001);
}

TEST_F(EarpointComparisonTest, ACopyOfTheTruthHasNoError) {
  const EarpointComparison comparison = compare(noise(0.5F, 0.5F));
  const RenderedEarpoint& copy = comparison.earpoints[0].renderings[0];
  // Files of 24 bits.
  EXPECT_NEAR(*copy.metrics[Metric::mag], 0.0, 1e-5);
  EXPECT_NEAR(*copy.metrics[Metric::level], 0.0, 1e-5);
}

TEST_F(EarpointComparisonTest, TextHasALineForEachEarpointAndJsonTheSameNumbers) {
  const EarpointComparison comparison = compare(noise(1.0F, 0.25F));
  const std::string text = text_of(comparison);
  EXPECT_EQ(std::ranges::count(text, '\n'), 3);
  EXPECT_NE(text.find("Near, to the left"), std::string::npos);
  EXPECT_NE(text.find("+12.0"), std::string::npos);
  const auto json = nlohmann::json::parse(json_of(comparison));
  const auto& row = json.at("earpoints").at(0);
  EXPECT_EQ(row.at("methods").at(1).at("method"), "dsp");
  EXPECT_DOUBLE_EQ(row.at("methods").at(0).at("errors").at("lre_db"),
                   *comparison.earpoints[0].renderings[0].metrics[Metric::lre]);
}

TEST_F(EarpointComparisonTest, PagePlaysFilesThatLieBesideIt) {
  const EarpointComparison comparison = compare(noise(1.0F, 0.25F));
  write_earpoint_page(comparison, folder_ / "out");
  const std::string page = read_text_file(folder_ / "out" / "index.html");
  int players = 0;
  const std::string mark = "<audio controls preload=\"metadata\" src=\"";
  for (auto at = page.find(mark); at != std::string::npos; at = page.find(mark, at + 1)) {
    const auto start = at + mark.size();
    const std::string file = page.substr(start, page.find('"', start) - start);
    EXPECT_TRUE(fs::is_regular_file(folder_ / "out" / file)) << file;
    ++players;
  }
  EXPECT_EQ(players, 4);  // the clip, the truth, two methods
  EXPECT_TRUE(fs::is_regular_file(folder_ / "out" / "overview.jpg"));
  EXPECT_EQ(page.find("http"), std::string::npos);
}

TEST_F(EarpointComparisonTest, ATruthOfAnotherLengthIsRefused) {
  try {
    (void)compare(noise(1.0F, 1.0F, 0.5));
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("lasts 0.50 s, the clip 1.00 s"), std::string::npos);
  }
}

}  // namespace
}  // namespace earpoint
