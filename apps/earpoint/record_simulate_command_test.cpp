#include "run_program.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/media/media.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class RecordSimulateCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("record_simulate." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "speech");
    // Stand-ins for people, so that the test is the same everywhere.
    ::setenv("EARPOINT_DATA_DIR", (folder_ / "nothing").c_str(), 1);
    std::string index = "file,speaker,gender,split\n";
    for (const std::string gender : {"female", "male"}) {
      Waveform sound(1, 24000, 16000);
      RandomStream random(gender.size());
      for (float& sample : sound.channel(0)) sample = static_cast<float>(random.uniform(-0.1, 0.1));
      write_sound(folder_ / "speech" / (gender + ".wav"), sound);
      index += gender + ".wav," + gender + " voice," + gender + ",train\n";
    }
    write_file(folder_ / "speech" / "speech.csv", index);
  }
  void TearDown() override {
    ::unsetenv("EARPOINT_DATA_DIR");
    fs::remove_all(folder_);
  }

  [[nodiscard]] std::vector<std::string> arguments(const std::vector<std::string>& more) const {
    std::vector<std::string> all = {"record",    "simulate",
                                    "--out",     (folder_ / "session").string(),
                                    "--speech",  (folder_ / "speech").string(),
                                    "--shoebox", "6,5,2.7,absorption=0.5",
                                    "--minutes", "0.25",
                                    "--cameras", "2",
                                    "--people",  "2",
                                    "--walks",   "0",
                                    "--size",    "64x48",
                                    "--fps",     "1",
                                    "--rays",    "50",
                                    "--jobs",    "1"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  /// The usual arguments with one flag's value changed.
  [[nodiscard]] std::vector<std::string> with(const std::string& flag,
                                              const std::string& value) const {
    std::vector<std::string> all = arguments({});
    const auto place = std::find(all.begin(), all.end(), flag);
    if (place == all.end()) return arguments({flag, value});
    *(place + 1) = value;
    return all;
  }

  /// Exit 2, one line on standard error.
  /// @return that line
  static std::string refusal(const std::vector<std::string>& all) {
    const ProgramOutcome outcome = run_earpoint(all);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    return outcome.errors;
  }

  fs::path folder_;
};

TEST_F(RecordSimulateCommand, MakesASessionAndGoesOnThere) {
  const ProgramOutcome outcome = run_earpoint(arguments({"--quiet"}));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.output, "");
  EXPECT_EQ(outcome.errors, "");
  const fs::path session = folder_ / "session";
  for (const char* name : {"session.json", "truth.json", "boxes.csv", "near-1.wav", "near-2.wav"}) {
    EXPECT_TRUE(fs::exists(session / name)) << name;
  }
  const MediaInfo movie = probe_media(session / "camera-2.mp4");
  EXPECT_EQ(movie.preferred(StreamKind::video)->width, 64);
  EXPECT_EQ(movie.preferred(StreamKind::audio)->sample_rate_hz, 48000);

  // Once more: everything is there already, and its folder is printed.
  const ProgramOutcome again = run_earpoint(arguments({}));
  EXPECT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_EQ(again.output, (session / "session.json").string() + "\n");
  EXPECT_NE(refusal(with("--snr", "10")).find("snr_db is 20.0 there, 10.0 here"),
            std::string::npos);
}

TEST_F(RecordSimulateCommand, RefusesBadArgumentsInOneLine) {
  EXPECT_EQ(refusal(with("--size", "64")),
            "earpoint: --size: expected WIDTHxHEIGHT with 32 to 4096 pixels, found '64'\n");
  EXPECT_NE(refusal(with("--minutes", "0.1")).find("--minutes"), std::string::npos);
  EXPECT_NE(refusal(with("--people", "5")).find("--people"), std::string::npos);
  EXPECT_NE(refusal(with("--drift", "nan")).find("--drift"), std::string::npos);
  EXPECT_NE(refusal(with("--split", "test")).find("speaker for the split test"), std::string::npos);
  EXPECT_NE(refusal({"record", "simulate"}).find("--out"), std::string::npos);
}

TEST_F(RecordSimulateCommand, SaysThatASceneHasNoRoom) {
  const std::string line = refusal(with("--shoebox", "2,2,2.7"));
  EXPECT_NE(line.find("has no space for a ring of 2 cameras"), std::string::npos) << line;
}

}  // namespace

}  // namespace earpoint
