#include "run_program.h"

#include <algorithm>
#include <filesystem>
#include <future>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTiny = R"({
 "format": "earpoint-train-1",
 "network": {"kind": "vigas", "blocks": 1, "layers_per_block": 2, "channels": 4, "fusion_width": 8,
             "conditioning_width": 8, "picture": {"width_px": 32, "height_px": 32, "channels": 2}},
 "data": {"window_samples": 4000, "validation_pairs": 2},
 "training": {"batch": 2, "steps": 2, "validate_every": 1}
})";

class TrainCommandTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("train_command." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    write_tiny_dataset(folder_ / "data", {.clips = 1});
    write_file(folder_ / "tiny.json", std::string_view(kTiny));
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] ProgramOutcome train(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {
        "train", (folder_ / "tiny.json").string(), "--data", (folder_ / "data").string(),
        "--out", (folder_ / "run").string(),       "--jobs", "1"};
    words.insert(words.end(), more.begin(), more.end());
    return run_earpoint(words);
  }

  fs::path folder_;
};

TEST_F(TrainCommandTest, SaysWhatIsMissingWhereTheProgramThatTrainsIs) {
  const fs::path alone = folder_ / "earpoint";
  fs::copy_file(EARPOINT_PROGRAM, alone);
  const ProgramOutcome outcome = run_program(alone, {"train", "--help"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.errors.find("keep earpoint-train in the same folder as earpoint"),
            std::string::npos)
      << outcome.errors;
  EXPECT_EQ(std::ranges::count(outcome.errors, '\n'), 1) << outcome.errors;
}

TEST_F(TrainCommandTest, WhatWasTrainedRendersAtOnce) {
  const ProgramOutcome trained = train({"--json", "--quiet"});
  ASSERT_EQ(trained.exit_code, 0) << trained.errors;
  EXPECT_TRUE(trained.errors.empty()) << trained.errors;
  const auto summary = nlohmann::json::parse(trained.output);
  EXPECT_EQ(summary.at("steps"), 2);
  EXPECT_EQ(summary.at("clips"), 4);
  EXPECT_EQ(summary.at("metric"), "mag");
  EXPECT_EQ(summary.at("ended_by"), "steps");

  const fs::path heard = folder_ / "heard.wav";
  write_sound(heard, [] {
    Waveform sound(2, 20000, 16000);
    for (std::size_t i = 0; i < sound.planar().size(); ++i) {
      sound.planar()[i] = 0.1F * static_cast<float>(i % 50) / 50.0F;
    }
    return sound;
  }());
  const ProgramOutcome rendered = run_earpoint(
      {"render", (folder_ / "data/test/room/0/view_1.png").string(), heard.string(), "--model",
       (folder_ / "run/best.safetensors").string(), "--speaker-box", "0.2,0.2,0.4,0.8",
       "--translate", "1,0,0", "-o", (folder_ / "there.wav").string(), "--quiet"});
  ASSERT_EQ(rendered.exit_code, 0) << rendered.errors;
  EXPECT_EQ(probe_sound(folder_ / "there.wav").frames, 20000);
}

TEST_F(TrainCommandTest, WhatIsSetIsPartOfTheRunsConfiguration) {
  ASSERT_EQ(train({"--set", "training.steps=1", "--set", "network.box=false", "--quiet"}).exit_code,
            0);
  const auto kept = nlohmann::json::parse(read_text_file(folder_ / "run/config.json"));
  EXPECT_EQ(kept.at("training").at("steps"), 1);
  EXPECT_EQ(kept.at("network").at("box"), false);
  EXPECT_EQ(kept.at("network").at("channels"), 4);
  // With the same settings it continues; without them the folder holds another run.
  EXPECT_EQ(train({"--set", "network.box=false", "--resume", "--quiet"}).exit_code, 0);
  const ProgramOutcome other = train({"--resume", "--quiet"});
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_NE(other.errors.find("another configuration"), std::string::npos) << other.errors;
}

TEST_F(TrainCommandTest, ARunIsNotOverwrittenAndGoesOnByResume) {
  ASSERT_EQ(train({"--quiet"}).exit_code, 0);
  const ProgramOutcome again = train({"--quiet"});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_NE(again.errors.find("holds a run already; continue it with --resume"), std::string::npos)
      << again.errors;
  std::string longer = kTiny;
  longer.replace(longer.find("\"steps\": 2"), 10, "\"steps\": 3");
  write_file(folder_ / "tiny.json", longer);
  const ProgramOutcome resumed = train({"--resume", "--quiet", "--json"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_EQ(nlohmann::json::parse(resumed.output).at("steps"), 3);
}

/// A network without batch norm, with a batch of three that cannot be shared evenly.
constexpr const char* kShared = R"({
 "format": "earpoint-train-1",
 "network": {"kind": "vigas", "blocks": 1, "layers_per_block": 3, "channels": 8, "fusion_width": 16,
             "conditioning_width": 8, "picture": null},
 "data": {"window_samples": 4000, "validation_pairs": 3},
 "training": {"batch": 3, "steps": 6, "validate_every": 3, "schedule": "cosine"}
})";

/// A free port of this machine.
int free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  auto* any = reinterpret_cast<sockaddr*>(&address);
  EXPECT_EQ(::bind(socket, any, size), 0);
  EXPECT_EQ(::getsockname(socket, any, &size), 0);
  ::close(socket);
  return ntohs(address.sin_port);
}

class SharedTrainingTest : public TrainCommandTest {
 protected:
  /// @param processes  1: without any launcher
  [[nodiscard]] std::vector<ProgramOutcome> train_by(
      int processes, const std::string& out, const std::string& config,
      const std::vector<std::string>& more = {}) const {
    const fs::path file = folder_ / (out + ".json");
    write_file(file, config);
    std::vector<std::string> words = {"train",  file.string(),
                                      "--data", (folder_ / "data").string(),
                                      "--out",  (folder_ / out).string(),
                                      "--jobs", "1",
                                      "--json", "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    if (processes == 1) return {run_earpoint(words)};
    const std::string port = std::to_string(free_port());
    std::vector<std::future<ProgramOutcome>> runs;
    for (int rank = 0; rank < processes; ++rank) {
      const std::vector<std::string> place = {"WORLD_SIZE=" + std::to_string(processes),
                                              "RANK=" + std::to_string(rank),
                                              "MASTER_ADDR=127.0.0.1", "MASTER_PORT=" + port};
      runs.push_back(std::async(std::launch::async, run_earpoint, words, place));
    }
    std::vector<ProgramOutcome> outcomes;
    for (auto& run : runs) outcomes.push_back(run.get());
    return outcomes;
  }

  /// The numbers of a CSV file, row by row.
  [[nodiscard]] std::vector<double> numbers(const std::string& path) const {
    std::istringstream text(read_text_file(folder_ / path));
    std::string line;
    std::getline(text, line);
    std::vector<double> found;
    while (std::getline(text, line)) {
      std::istringstream cells(line);
      for (std::string cell; std::getline(cells, cell, ',');) found.push_back(std::stod(cell));
    }
    return found;
  }
};

void expect_equal_but_for_rounding(const fs::path& found, const fs::path& expected) {
  const auto ours = read_safetensors(found).tensors;
  const auto theirs = read_safetensors(expected).tensors;
  ASSERT_EQ(ours.size(), theirs.size());
  for (const auto& [name, tensor] : theirs) {
    const auto a = ours.at(name).as<float>();
    const auto b = tensor.as<float>();
    ASSERT_EQ(a.size(), b.size()) << name;
    // A mean over clips is summed in another order: 1e-7 of a gradient. Adam divides a gradient by
    // its size, so that a weight whose gradient is nearly zero may move by a thousandth of a step
    // of 1e-3 otherwise.
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 6e-6) << name << " " << i;
  }
}

TEST_F(SharedTrainingTest, TwoProcessesLearnWhatOneDoesFromTheSameBatch) {
  ASSERT_EQ(train_by(1, "alone", kShared)[0].exit_code, 0);
  const std::vector<ProgramOutcome> both = train_by(2, "both", kShared);
  for (const ProgramOutcome& outcome : both) {
    ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
    EXPECT_EQ(outcome.errors, "");
  }
  // Only the first process prints the summary.
  EXPECT_EQ(nlohmann::json::parse(both[0].output).at("clips"), 18);
  EXPECT_EQ(both[1].output, "");
  const std::vector<double> expected = numbers("alone/steps.csv");
  const std::vector<double> found = numbers("both/steps.csv");
  ASSERT_EQ(expected.size(), 18U);
  ASSERT_EQ(found.size(), expected.size());
  // The same rounding as in the weights: a loss is a mean over clips, too.
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i], expected[i], 1e-5 * expected[i]) << i;
  }
  expect_equal_but_for_rounding(folder_ / "both/checkpoint.safetensors",
                                folder_ / "alone/checkpoint.safetensors");
}

TEST_F(SharedTrainingTest, TwoProcessesGoOnWithWhatTwoBegan) {
  std::string shorter = kShared;
  shorter.replace(shorter.find("\"steps\": 6"), 10, "\"steps\": 3");
  // The same learning rates, whatever the run's length.
  shorter.replace(shorter.find(", \"schedule\": \"cosine\""), 22, "");
  std::string longer = shorter;
  longer.replace(longer.find("\"steps\": 3"), 10, "\"steps\": 6");
  ASSERT_EQ(train_by(2, "unbroken", longer)[0].exit_code, 0);
  ASSERT_EQ(train_by(2, "broken", shorter)[0].exit_code, 0);
  for (const ProgramOutcome& outcome : train_by(2, "broken", longer, {"--resume"})) {
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  }
  EXPECT_EQ(numbers("broken/steps.csv"), numbers("unbroken/steps.csv"));
}

TEST_F(SharedTrainingTest, AllEndWhenOneCannotGoOn) {
  ASSERT_EQ(train_by(1, "run", kShared)[0].exit_code, 0);
  // The first process finds a run in the folder; the other reports that the first is lost.
  const std::vector<ProgramOutcome> both = train_by(2, "run", kShared);
  EXPECT_EQ(both[0].exit_code, 2);
  EXPECT_NE(both[0].errors.find("holds a run already"), std::string::npos) << both[0].errors;
  EXPECT_EQ(both[1].exit_code, 2);
  EXPECT_NE(both[1].errors.find("another process was lost"), std::string::npos) << both[1].errors;
  std::string single = kShared;
  single.replace(single.find("\"batch\": 3"), 10, "\"batch\": 1");
  for (const ProgramOutcome& outcome : train_by(2, "single", single)) {
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.errors.find("a clip for each of 2 processes, found 1"), std::string::npos)
        << outcome.errors;
  }
}

TEST_F(TrainCommandTest, BadUseIsOneLine) {
  const auto error_of = [&](const std::vector<std::string>& more) {
    const ProgramOutcome outcome = train(more);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(std::ranges::count(outcome.errors, '\n'), 1) << outcome.errors;
    return outcome.errors;
  };
  EXPECT_NE(error_of({"--device", "quantum"}).find("--device quantum"), std::string::npos);
  EXPECT_NE(error_of({"--minutes", "0"}).find("--minutes: expected more than 0"),
            std::string::npos);
  EXPECT_NE(error_of({"--set", "steps"}).find("--set steps: expected KEY=VALUE"),
            std::string::npos);
  EXPECT_NE(error_of({"--set", "training.bathc=2"})
                .find("--set training.bathc=2: 'training': unknown key 'bathc'"),
            std::string::npos);
  EXPECT_NE(error_of({"--set", "network.channels=few"}).find("channels: expected"),
            std::string::npos)
      << error_of({"--set", "network.channels=few"});
  // Several folders are allowed for pairs of viewpoints, as for this network, but they must exist.
  EXPECT_NE(error_of({"--data", "nowhere"}).find("nowhere: no such folder"), std::string::npos);
  std::string misspelt = kTiny;
  misspelt.replace(misspelt.find("\"batch\""), 7, "\"bathc\"");
  write_file(folder_ / "tiny.json", misspelt);
  EXPECT_NE(error_of({}).find("tiny.json: 'training': unknown key 'bathc'"), std::string::npos)
      << error_of({});
}

TEST_F(TrainCommandTest, BadFilesEndItByNameOrAreSkipped) {
  write_file(folder_ / "data/train/room/0/view_1.png", std::string_view("no picture"));
  const ProgramOutcome ended = train({"--quiet"});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_NE(ended.errors.find("view_1.png"), std::string::npos) << ended.errors;
  fs::remove_all(folder_ / "run");
  const ProgramOutcome skipped = train({"--quiet", "--skip-bad"});
  EXPECT_EQ(skipped.exit_code, 0);
  EXPECT_NE(skipped.errors.find("skipped: "), std::string::npos) << skipped.errors;
}

}  // namespace

}  // namespace earpoint
