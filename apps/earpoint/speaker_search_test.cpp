#include "gtf_file.h"
#include "run_program.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/media/image_file.h>
#include <earpoint/media/media.h>
#include <earpoint/media/movie_writer.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// What locate and render do if the speaker is not given.
class SpeakerSearch : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(testing::TempDir()) / ("speaker_search_" + name);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    ASSERT_EQ(::setenv("EARPOINT_MODELS_DIR", folder_.c_str(), 1), 0);
    write_gtf_file(at("gtf.safetensors"));
    write_image(at("frame.png"), Image(64, 48, 3, 90));
    write_noise("sound.wav", 2, 1.0F);
  }
  void TearDown() override {
    fs::remove_all(folder_);
    ::unsetenv("EARPOINT_MODELS_DIR");
  }

  [[nodiscard]] std::string at(const char* name) const { return (folder_ / name).string(); }

  /// Writes 1.5 s of noise. The second channel is the first times `right`; if that is 1, it has
  /// independent noise.
  void write_noise(const char* name, int channels, float right) const {
    Waveform sound(channels, 24000, 16000);
    RandomStream random(5);
    for (float& sample : sound.planar()) sample = static_cast<float>(0.05 * random.normal());
    if (channels == 2 && right != 1.0F) {
      for (int i = 0; i < 24000; ++i) sound.channel(1)[i] = right * sound.channel(0)[i];
    }
    write_sound(at(name), sound, SampleFormat::float32);
  }

  ProgramOutcome run(const std::vector<std::string>& arguments) const {
    const ProgramOutcome outcome = run_earpoint(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return outcome;
  }

  fs::path folder_;
};

TEST_F(SpeakerSearch, LocateTellsFramesOfAGivenBoxInThePromisedForm) {
  const ProgramOutcome outcome =
      run({"locate", at("frame.png"), at("sound.wav"), "--speaker-box", "0.1,0.2,0.3,0.9", "--json",
           "--quiet", "-o", at("boxes.csv"), "--plot", at("people.mp4")});
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json["detector"], "given boxes");
  ASSERT_EQ(json["frames"].size(), 8U);  // 1.5 s: seven fifths of a second, and half of one
  for (const auto& frame : json["frames"]) {
    EXPECT_TRUE(frame["time_s"].is_number());
    ASSERT_EQ(frame["people"].size(), 1U);
    EXPECT_EQ(frame["people"][0]["track"], 0);
    EXPECT_EQ(frame["people"][0]["box"], nlohmann::json::array({0.1, 0.2, 0.3, 0.9}));
    EXPECT_GT(frame["people"][0]["speaking"], 0.9);
    EXPECT_LE(frame["people"][0]["speaking"], 1.0);
  }
  EXPECT_TRUE(json.contains("windows") && json.contains("speaker"));
  EXPECT_EQ(FrameReader(at("people.mp4")).info().width, 64);
  // render reads what locate writes.
  run({"render", at("frame.png"), at("sound.wav"), "--speaker-boxes", at("boxes.csv"),
       "--translate", "1,0,0", "-o", at("there.wav"), "--quiet"});
  EXPECT_TRUE(fs::exists(at("there.wav")));
}

TEST_F(SpeakerSearch, WithoutADetectorOrAPictureBothSaySoAndGoOn) {
  const ProgramOutcome still =
      run({"render", at("frame.png"), at("sound.wav"), "--translate", "1,0,0", "-o", at("a.wav")});
  EXPECT_NE(still.errors.find("people.safetensors is not among the shipped models"),
            std::string::npos)
      << still.errors;
  const ProgramOutcome sound = run({"locate", at("sound.wav"), "--json", "--quiet"});
  const auto json = nlohmann::json::parse(sound.output);
  EXPECT_EQ(json["detector"], "none");
  EXPECT_TRUE(json["frames"][0]["people"].empty());
  const ProgramOutcome asked_not = run({"render", at("frame.png"), at("sound.wav"), "--detector",
                                        "none", "--translate", "1,0,0", "-o", at("b.wav")});
  EXPECT_EQ(asked_not.errors.find("people.safetensors"), std::string::npos) << asked_not.errors;
}

TEST_F(SpeakerSearch, PutsTheVoiceOfMonoAndStereoAtTheSpeakerUnlessToldNotTo) {
  write_noise("mono.wav", 1, 1.0F);
  write_noise("panned.wav", 2, 0.5F);
  const auto levels = [&](const std::string& sound, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{
        "render",    at("frame.png"), sound,   "--model", "dsp",         "--speaker",
        "0.5,1.5,0", "--translate",   "0,0,0", "-o",      at("out.wav"), "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramOutcome outcome = run(arguments);
    const auto json = nlohmann::json::parse(outcome.output);
    EXPECT_EQ(json["placed"], outcome.errors.find("by head filters") != std::string::npos);
    return json["source"]["left_db"].get<double>() - json["source"]["right_db"].get<double>();
  };
  // A voice 72 degrees to the left is at least 5 dB louder at the left ear of any head.
  for (const char* name : {"mono.wav", "panned.wav"}) EXPECT_GT(levels(at(name), {}), 5.0) << name;
  // 20 log10 of 2 is 6.0206.
  EXPECT_NEAR(levels(at("panned.wav"), {"--recording", "binaural"}), 6.02, 0.01);
  // Noise that differs between the channels counts as binaural by default. The levels of 24,000
  // values each differ by 0.06 dB (standard error).
  EXPECT_NEAR(levels(at("sound.wav"), {}), 0.0, 0.5);
  EXPECT_GT(levels(at("sound.wav"), {"--recording", "stereo"}), 5.0);
}

TEST_F(SpeakerSearch, RefusesInOneLineWhatItCannotUse) {
  const auto refusal = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--quiet"});
    const ProgramOutcome outcome = run_earpoint(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.errors;
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    return outcome.errors;
  };
  EXPECT_NE(refusal({"locate", at("sound.wav"), "--plot", at("people.mp4")}).find("no picture"),
            std::string::npos);
  EXPECT_NE(refusal({"locate", at("frame.png"), at("sound.wav"), "--detector", at("none.onnx")})
                .find("none.onnx"),
            std::string::npos);
  EXPECT_NE(refusal({"render", at("sound.wav"), "--recording", "surround", "--yaw", "1", "-o",
                     at("out.wav")})
                .find("--recording"),
            std::string::npos);
  write_file(at("people.csv"), "time_s,track,x0,y0,x1,y1,speaking,voice\n0,0,0.1,0.1,2,2,1\n");
  EXPECT_NE(refusal({"render", at("frame.png"), at("sound.wav"), "--speaker-boxes",
                     at("people.csv"), "--yaw", "1", "-o", at("out.wav")})
                .find("people.csv: line 2"),
            std::string::npos);
  // An empty movie file.
  write_file(at("empty.mp4"), "");
  EXPECT_NE(refusal({"locate", at("empty.mp4")}).find("empty.mp4"), std::string::npos);
}

TEST_F(SpeakerSearch, TakesAMovieOfOnePicture) {
  MovieWriter writer(at("one.mp4"), 64, 48, 25.0, 48000);
  writer.write_picture(Image(64, 48, 3, 100));
  Waveform sound(2, 48000, 48000);
  RandomStream random(5);
  for (float& sample : sound.planar()) sample = static_cast<float>(0.05 * random.normal());
  writer.write_sound(sound);
  writer.close();
  const ProgramOutcome outcome =
      run({"locate", at("one.mp4"), "--speaker-box", "0.1,0.2,0.3,0.9", "--json", "--quiet"});
  EXPECT_EQ(nlohmann::json::parse(outcome.output)["frames"].size(), 5U);
}

}  // namespace
}  // namespace earpoint
