#include "run_program.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/scene/export.h>
#include <earpoint/scene/homes.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class SimulateCommandTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("simulate_command." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "speech");
    // Stand-ins for furniture and people, so that the test is the same everywhere.
    ::setenv("EARPOINT_DATA_DIR", (folder_ / "nothing").c_str(), 1);
    std::string index = "file,speaker,gender,split\n";
    for (const std::string gender : {"female", "male"}) {
      Waveform sound(1, 16000, 16000);
      RandomStream random(gender.size());
      for (float& sample : sound.channel(0)) sample = static_cast<float>(random.uniform(-0.1, 0.1));
      write_sound(folder_ / "speech" / (gender + ".wav"), sound);
      index += gender + ".wav," + gender + " voice," + gender + ",test\n";
    }
    write_file(folder_ / "speech" / "speech.csv", index);
  }
  void TearDown() override {
    ::unsetenv("EARPOINT_DATA_DIR");
    fs::remove_all(folder_);
  }

  /// A quick simulation of two conversations in one home.
  [[nodiscard]] std::vector<std::string> arguments(const std::string& out) const {
    return {"simulate",
            "--scenes",
            "1",
            "--conversations",
            "2",
            "--split",
            "test",
            "--speech",
            (folder_ / "speech").string(),
            "--out",
            (folder_ / out).string(),
            "--rays",
            "50",
            "--duration",
            "0.2",
            "--jobs",
            "1"};
  }

  [[nodiscard]] std::map<std::string, std::string> contents_of(const std::string& out) const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / out)) {
      if (!entry.is_regular_file()) continue;
      files[entry.path().lexically_relative(folder_ / out).string()] = read_text_file(entry.path());
    }
    return files;
  }

  fs::path folder_;
};

/// Starts the program and kills it as soon as `path` exists.
void kill_when_there(const std::vector<std::string>& arguments, const fs::path& path) {
  std::vector<std::string> words{EARPOINT_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  words.emplace_back("--quiet");
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  pid_t child = 0;
  ASSERT_EQ(::posix_spawn(&child, EARPOINT_PROGRAM, nullptr, nullptr, pointers.data(), environ), 0);
  int status = 0;
  while (!fs::exists(path) && ::waitpid(child, &status, WNOHANG) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ::kill(child, SIGKILL);
  ::waitpid(child, &status, 0);
}

TEST_F(SimulateCommandTest, KilledAtAnyMomentItGoesOnToTheSameBytes) {
  ASSERT_EQ(run_earpoint(arguments("whole")).exit_code, 0);
  const auto expected = contents_of("whole");
  EXPECT_TRUE(expected.contains("test/home-0000/cleaned_metadata_v3.json"));
  const fs::path scene = folder_ / "killed/test/home-0000";
  // Killed while the first conversation is written, right after it, and while the second is
  // written.
  kill_when_there(arguments("killed"), scene / ".0.partial/rir_1_0.wav");
  EXPECT_FALSE(fs::exists(scene / "0"));
  kill_when_there(arguments("killed"), scene / "0");
  kill_when_there(arguments("killed"), scene / ".1.partial/view_0.png");
  EXPECT_FALSE(fs::exists(scene / "1"));
  const ProgramOutcome outcome = run_earpoint(arguments("killed"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(contents_of("killed"), expected);
}

// The C library selects its functions by the processor; ./dev processors emulates another processor
// completely.
TEST_F(SimulateCommandTest, TheFunctionsOfOlderProcessorsGiveTheSameBytes) {
  const auto one = [&](const std::string& out) {
    std::vector<std::string> words = arguments(out);
    std::ranges::replace(words, "2", "1");  // of conversations
    words.insert(words.end(), {"--viewpoints", "2"});
    return words;
  };
  ASSERT_EQ(run_earpoint(one("this")).exit_code, 0);
  const std::string older = "GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX512F,-AVX2,-FMA,-FMA4,-AVX";
  ASSERT_EQ(run_earpoint(one("older"), {older}).exit_code, 0);
  const auto expected = contents_of("this");
  EXPECT_TRUE(expected.contains("test/home-0000/0/view_1.png"));
  EXPECT_TRUE(expected.contains("test/home-0000/0/rir_1_1.wav"));
  EXPECT_EQ(contents_of("older"), expected);
}

TEST_F(SimulateCommandTest, AScanOfOnesOwnIsSimulatedAndSummedUp) {
  const Home home = make_home(3, {}, FurnitureLibrary());
  write_glb(home.scene, folder_ / "flat.glb");
  write_file(folder_ / "materials.json", R"({"extends": "standard", "patterns": {}})");
  std::vector<std::string> words = arguments("out");
  words[1] = "--scene";
  words[2] = (folder_ / "flat.glb").string();
  words[4] = "1";
  for (const char* word : {"--json", "--quiet", "--heard"}) words.emplace_back(word);
  const ProgramOutcome outcome = run_earpoint(words);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto summary = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(summary.at("scenes").at("test"), 1);
  EXPECT_EQ(summary.at("viewpoints"), 4);
  EXPECT_EQ(summary.at("responses"), 8);
  EXPECT_EQ(summary.at("voices"), 2);
  EXPECT_GT(summary.at("run").at("core_seconds").at("trace"), 0.0);
  // Four viewpoints hear two speakers, a second each; 1e-4 h is a third of a second.
  EXPECT_NEAR(summary.at("hours").get<double>(), 8.0 / 3600.0, 1e-4);
  EXPECT_EQ(probe_sound(folder_ / "out/test/flat/0/heard_3_1.wav").channels, 2);
  EXPECT_EQ(read_pair_list(folder_ / "out/pairs-test.json").pairs.size(), 4U);
}

TEST_F(SimulateCommandTest, WhatAnImporterDoubtsIsTold) {
  // A box of 5 x 4 x 3 m without a ceiling, which is added; no pattern knows the name of its floor.
  write_file(folder_ / "box.obj",
             std::string_view("v 0 0 0\nv 5 0 0\nv 5 4 0\nv 0 4 0\nv 0 0 3\nv 5 0 3\n"
                              "v 5 4 3\nv 0 4 3\ng xyzzy\nf 1 2 3 4\ng brick\n"
                              "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"));
  std::vector<std::string> words = arguments("out");
  words[1] = "--scene";
  words[2] = (folder_ / "box.obj").string();
  for (const char* word : {"--up", "z", "--close-ceiling", "--quiet"}) words.emplace_back(word);
  const ProgramOutcome outcome = run_earpoint(words);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("box.obj: "), std::string::npos) << outcome.errors;
  EXPECT_NE(outcome.errors.find("xyzzy"), std::string::npos) << outcome.errors;
  // Two conversations share the scene, and the warnings are printed once.
  EXPECT_EQ(outcome.errors.find("xyzzy"), outcome.errors.rfind("xyzzy")) << outcome.errors;
}

TEST_F(SimulateCommandTest, BadUseIsOneLineAndLeavesNothing) {
  const auto error_of = [&](const std::string& flag, const std::string& value) {
    std::vector<std::string> words = arguments("out");
    words.push_back(flag);
    words.push_back(value);
    const ProgramOutcome outcome = run_earpoint(words);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    EXPECT_FALSE(fs::exists(folder_ / "out"));
    return outcome.errors;
  };
  EXPECT_NE(error_of("--shard", "2/2").find("--shard: expected i/n"), std::string::npos);
  EXPECT_NE(error_of("--materials", "m.json").find("--scene"), std::string::npos);
  EXPECT_NE(error_of("--viewpoints", "1").find("--viewpoints: expected 2 or more"),
            std::string::npos);
  EXPECT_NE(error_of("--other-rooms", "1.5").find("--other-rooms: expected 0 to 1, found 1.5"),
            std::string::npos);
  EXPECT_NE(error_of("--reach", "0.5").find("--reach: expected 1 to 100, found 0.5"),
            std::string::npos);
  EXPECT_NE(error_of("--height-spread", "-1").find("--height-spread: expected 0 to 1"),
            std::string::npos);
  fs::remove(folder_ / "speech/speech.csv");
  EXPECT_NE(error_of("--seed", "2").find("./dev speech"), std::string::npos);
}

TEST_F(SimulateCommandTest, AnotherSplitWithoutVoicesIsRefused) {
  std::vector<std::string> words = arguments("out");
  words[6] = "train";
  const ProgramOutcome outcome = run_earpoint(words);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.errors.find("speaker for the split train"), std::string::npos)
      << outcome.errors;
}

}  // namespace

}  // namespace earpoint
