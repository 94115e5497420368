#include "gtf_file.h"
#include "run_program.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/dataset/ambient.h>
#include <earpoint/dataset/sample.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class EnhanceCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(testing::TempDir()) / ("enhance_command_" + name);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write_gtf_file(at("gtf.safetensors"));
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string at(const char* name) const { return (folder_ / name).string(); }

  void write_noise(int rate_hz, double seconds) const {
    Waveform sound(2, static_cast<std::ptrdiff_t>(seconds * rate_hz), rate_hz);
    RandomStream random(5);
    for (float& sample : sound.planar()) sample = static_cast<float>(0.05 * random.normal());
    write_sound(at("sound.wav"), sound, SampleFormat::float32);
  }

  [[nodiscard]] ProgramOutcome enhance(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"enhance", at("sound.wav"), "--model",
                                          at("gtf.safetensors"), "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_earpoint(arguments);
  }

  fs::path folder_;
};

TEST_F(EnhanceCommand, WritesOneChannelOfTheRecordingsRateAndLength) {
  for (const int rate : {16000, 44100, 48000}) {
    write_noise(rate, 2.3);
    const ProgramOutcome outcome = enhance({"-o", at("dry.wav")});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
    const Waveform dry = read_sound(at("dry.wav"));
    EXPECT_EQ(dry.channels(), 1);
    EXPECT_EQ(dry.sample_rate_hz(), rate);
    EXPECT_EQ(dry.samples(), static_cast<std::ptrdiff_t>(2.3 * rate));
    EXPECT_TRUE(std::ranges::any_of(dry.planar(), [](float x) { return x != 0.0F; }));
  }
}

TEST_F(EnhanceCommand, ItsJsonSaysWhatWasAssumed) {
  write_noise(48000, 1.5);
  const ProgramOutcome outcome = enhance({"-o", at("dry.flac"), "--json", "--ambient", "mmse"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json.at("model"), at("gtf.safetensors"));
  EXPECT_EQ(json.at("ambient"), "mmse");
  EXPECT_EQ(json.at("sample_rate_hz"), 48000);
  EXPECT_EQ(json.at("model_rate_hz"), 16000);
  EXPECT_TRUE(json.at("output").at("level_db").is_number());
  // No speaker, no picture, a band above the model's, and how ambient sound is found.
  EXPECT_EQ(json.at("assumed").size(), 4U) << json.dump(2);

  const ProgramOutcome told =
      enhance({"-o", at("dry.flac"), "--json", "--speaker", "2,0,0", "--band", "model"});
  ASSERT_EQ(told.exit_code, 0) << told.errors;
  EXPECT_EQ(nlohmann::json::parse(told.output).at("assumed").size(), 3U);
}

TEST_F(EnhanceCommand, WritesIntoAPipeAndNothingElseThere) {
  write_noise(16000, 1.5);
  const ProgramOutcome outcome = enhance({"-o", "-"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  write_file(at("piped.wav"), outcome.output);
  const Waveform piped = read_sound(at("piped.wav"));
  ASSERT_EQ(enhance({"-o", at("dry.wav")}).exit_code, 0);
  EXPECT_TRUE(std::ranges::equal(piped.planar(), read_sound(at("dry.wav")).planar()));
  EXPECT_EQ(enhance({"-o", "-", "--json"}).exit_code, 2);
}

TEST_F(EnhanceCommand, TheShippedNetworkKeepsPausesQuiet) {
  // Nobody speaks. A former network, which had only heard speech, made white noise 85 dB louder.
  for (const double corner_hz : {20.0, 500.0, 8000.0}) {
    for (const double level_db : {-50.0, -30.0}) {
      Waveform pause(2, std::ptrdiff_t{4} * 48000, 48000);
      RandomStream random(7);
      add_room_noise(pause, level_db, random, 0, corner_hz);
      write_sound(at("sound.wav"), pause, SampleFormat::float32);
      const std::string models = std::string(EARPOINT_SOURCE_DIR) + "/models";
      const ProgramOutcome outcome =
          run_earpoint({"enhance", at("sound.wav"), "-o", at("dry.wav"), "--quiet"},
                       {"EARPOINT_MODELS_DIR=" + models});
      ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
      const Waveform dry = read_sound(at("dry.wav"));
      // One channel against two, of which the network hears what is above 80 Hz.
      const double ratio = 2.0 * energy(dry.planar()) / energy(highpass(pause, 80.0).planar());
      // Other draws of such noise become 17 to 45 dB quieter.
      EXPECT_LT(10.0 * std::log10(ratio), -10.0) << corner_hz << " Hz, " << level_db << " dB";
    }
  }
}

TEST_F(EnhanceCommand, RefusesWhatItCannotUseInOneLine) {
  write_noise(16000, 1.5);
  const auto refused = [&](const std::vector<std::string>& more, const std::string& part) {
    const ProgramOutcome outcome = enhance(more);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.errors;
    EXPECT_EQ(std::ranges::count(outcome.errors, '\n'), 1) << outcome.errors;
    EXPECT_NE(outcome.errors.find(part), std::string::npos) << outcome.errors;
  };
  refused({"-o", at("dry.xyz")}, ".xyz");
  refused({"-o", at("dry.wav"), "--ambient", "wiener"}, "--ambient");
  refused({}, "-o");
  const ProgramOutcome none =
      run_earpoint({"enhance", at("sound.wav"), "-o", at("dry.wav"), "--quiet"},
                   {"EARPOINT_MODELS_DIR=" + folder_.string()});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.errors.find("--model"), std::string::npos) << none.errors;
  EXPECT_FALSE(fs::exists(at("dry.wav")));
}

}  // namespace
}  // namespace earpoint
