#include "gtf_file.h"
#include "run_program.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/dataset_testing/tiny_published.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/network_testing/random_weights.h>
#include <earpoint/vigas/weights.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// A home with three conversations of two voices, simulated once for all tests.
class EvaluateCommandTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::path(testing::TempDir()) / ("evaluate_command." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "speech");
    // Stand-ins for furniture and people, so that the test is the same everywhere.
    ::setenv("EARPOINT_DATA_DIR", (folder_ / "nothing").c_str(), 1);
    std::string index = "file,speaker,gender,split\n";
    for (const std::string gender : {"female", "male"}) {
      Waveform sound(1, 20000, 16000);
      RandomStream random(gender.size());
      for (float& sample : sound.channel(0)) sample = static_cast<float>(random.uniform(-0.1, 0.1));
      write_sound(folder_ / "speech" / (gender + ".wav"), sound);
      index += gender + ".wav," + gender + " voice," + gender + ",test\n";
    }
    write_file(folder_ / "speech" / "speech.csv", index);
    const ProgramOutcome outcome = run_earpoint(
        {"simulate", "--scenes", "1", "--conversations", "3", "--split", "test", "--speech",
         (folder_ / "speech").string(), "--out", (folder_ / "data").string(), "--rays", "50",
         "--duration", "0.3", "--jobs", "1", "--quiet"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  }
  static void TearDownTestSuite() {
    ::unsetenv("EARPOINT_DATA_DIR");
    fs::remove_all(folder_);
  }

  static ProgramOutcome evaluate(const fs::path& data, const std::vector<std::string>& more) {
    std::vector<std::string> words{"evaluate", "--data", data.string(), "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    return run_earpoint(words);
  }

  /// A copy of the data set to break.
  static fs::path copy_of_data(const std::string& name) {
    fs::copy(folder_ / "data", folder_ / name, fs::copy_options::recursive);
    return folder_ / name;
  }

  inline static fs::path folder_;
};

TEST_F(EvaluateCommandTest, JsonHasARowPerMethodWithIntervals) {
  const ProgramOutcome outcome = evaluate(folder_ / "data", {"--methods", "input,dsp", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors, "");
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json.at("clips"), 12);
  EXPECT_EQ(json.at("conversations"), 3);
  ASSERT_EQ(json.at("rows").size(), 2U);
  EXPECT_EQ(json.at("rows")[0].at("method"), "input");
  EXPECT_EQ(json.at("rows")[1].at("method"), "dsp");
  for (const auto& row : json.at("rows")) {
    for (const char* key : {"mag", "lre_db", "level_db", "itd_us", "l2", "stft_distance"}) {
      const auto& cell = row.at(key);
      EXPECT_GT(cell.at("mean"), 0.0) << key;
      EXPECT_LE(cell.at("low"), cell.at("mean")) << key;
      EXPECT_GE(cell.at("high"), cell.at("mean")) << key;
      EXPECT_GT(row.at("released").at(key).at("mean"), 0.0) << key;
    }
  }
  EXPECT_EQ(json.at("rows")[0].at("mag").at("ratio").at("value"), 1.0);
}

TEST_F(EvaluateCommandTest, ThreadsDoNotChangeTheNumbers) {
  const ProgramOutcome two = evaluate(folder_ / "data", {"--json", "--jobs", "2"});
  const ProgramOutcome one = evaluate(folder_ / "data", {"--json", "--jobs", "1"});
  ASSERT_EQ(one.exit_code, 0) << one.errors;
  EXPECT_EQ(one.output, two.output);
}

TEST_F(EvaluateCommandTest, OraclesAreRowsOfTheirOwn) {
  const ProgramOutcome outcome = evaluate(
      folder_ / "data", {"--methods", "input,oracle-gain", "--oracles", "--json", "--limit", "3"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  ASSERT_EQ(json.at("rows").size(), 6U);
  EXPECT_EQ(json.at("rows")[5].at("method"), "oracle-all");
  EXPECT_EQ(json.at("rows")[5].at("is_oracle"), true);
  EXPECT_LT(json.at("rows")[5].at("mag").at("mean"), 1e-5);
}

TEST_F(EvaluateCommandTest, TableAndLimitAreForPeople) {
  const ProgramOutcome outcome = evaluate(folder_ / "data", {"--methods", "input", "--limit", "3"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("Mag"), std::string::npos);
  // Pairs are spread over the list: one of every conversation.
  EXPECT_NE(outcome.output.find("3 clips of 3 conversations"), std::string::npos) << outcome.output;
}

TEST_F(EvaluateCommandTest, RoomNoiseIsTheSameEachTimeAndMakesTheSourceWorse) {
  const auto mag = [](const std::vector<std::string>& more) {
    std::vector<std::string> words{"--methods", "input", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramOutcome outcome = evaluate(folder_ / "data", words);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    const auto json = nlohmann::json::parse(outcome.output);
    EXPECT_EQ(json.at("ambient_db").is_null(), more.empty());
    return json.at("rows")[0].at("mag").at("mean").get<double>();
  };
  const double quiet = mag({});
  const double noisy = mag({"--ambient", "-20"});
  EXPECT_GT(noisy, quiet);
  EXPECT_EQ(noisy, mag({"--ambient", "-20", "--jobs", "1"}));
  EXPECT_EQ(noisy, mag({"--ambient", "-20,bandpass"}));
  EXPECT_NE(noisy, mag({"--ambient", "mmse,-20"}));
  EXPECT_EQ(evaluate(folder_ / "data", {"--ambient", "wiener"}).exit_code, 2);
}

TEST_F(EvaluateCommandTest, EnhancementAsksForDrySpeechInTheSameForm) {
  const ProgramOutcome outcome = evaluate(folder_ / "data", {"--enhance", "--oracles", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json.at("target"), "near_microphone");
  EXPECT_EQ(json.at("ambient_db"), -40.0);
  ASSERT_EQ(json.at("rows").size(), 6U);
  const auto& input = json.at("rows")[0];
  EXPECT_EQ(input.at("method"), "input");
  EXPECT_GT(input.at("mag").at("low"), 0.0);
  EXPECT_LT(json.at("rows")[5].at("mag").at("mean"), 1e-5);
  const ProgramOutcome text = evaluate(folder_ / "data", {"--enhance"});
  EXPECT_NE(text.output.find("Mag"), std::string::npos) << text.output;
  EXPECT_NE(text.output.find("ESTOI"), std::string::npos) << text.output;
  EXPECT_EQ(text.output.find("LRE"), std::string::npos) << text.output;
}

TEST_F(EvaluateCommandTest, BrokenPairsAreNamedAndSkippedOnlyWhenAsked) {
  const fs::path data = copy_of_data("broken");
  const fs::path scene = data / "test/home-0000";
  // Responses in three conversations: missing, empty, of too low a rate, with NaN.
  // Every viewpoint is the target of one pair.
  for (const std::string speaker : {"0", "1"}) {
    fs::remove(scene / ("0/rir_0_" + speaker + ".wav"));
    write_file(scene / ("0/rir_1_" + speaker + ".wav"), std::string_view(""));
    write_sound(scene / ("1/rir_0_" + speaker + ".wav"), Waveform(2, 100, 8000));
    const fs::path path = scene / ("2/rir_1_" + speaker + ".wav");
    std::string bytes = read_text_file(path);
    std::fill(bytes.end() - 8, bytes.end(), '\xFF');  // the last sample of both ears
    write_file(path, bytes);
  }
  const ProgramOutcome stopped = evaluate(data, {"--methods", "input"});
  EXPECT_EQ(stopped.exit_code, 2);
  EXPECT_EQ(std::count(stopped.errors.begin(), stopped.errors.end(), '\n'), 1) << stopped.errors;
  EXPECT_NE(stopped.errors.find("home-0000, clip 0"), std::string::npos) << stopped.errors;
  EXPECT_NE(stopped.errors.find("--skip-bad"), std::string::npos) << stopped.errors;

  const ProgramOutcome outcome = evaluate(data, {"--methods", "input", "--skip-bad", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json.at("clips").get<std::size_t>() + json.at("skipped").size(), 12U);
  EXPECT_GE(json.at("clips"), 1);
  const auto is_named = [&](const std::string& file, const std::string& problem) {
    return std::ranges::any_of(json.at("skipped"), [&](const auto& pair) {
      const std::string text = pair.at("problem");
      return text.find(file) != std::string::npos && text.find(problem) != std::string::npos;
    });
  };
  EXPECT_TRUE(is_named("0/rir_0_", "no such file")) << outcome.errors;
  EXPECT_TRUE(is_named("0/rir_1_", "empty")) << outcome.errors;
  EXPECT_TRUE(is_named("1/rir_0_", "8000 Hz")) << outcome.errors;
  EXPECT_TRUE(is_named("2/rir_1_", "finite")) << outcome.errors;
  EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'),
            std::ssize(json.at("skipped")));
}

/// A small ViGAS network with random weights.
void write_network(const fs::path& path, const std::string& name) {
  ViGasDescription description;
  description.pose_encoding = PoseEncoding::full;
  description.inputs = {{"tgt_pose", 3}, {"tgt_rotation", 6}, {"bboxes", 4}};
  description.fusion_width = 8;
  description.conditioning_width = 8;
  description.channels = 8;
  description.blocks = 1;
  description.layers_per_block = 2;
  ViGasWeights weights{.description = description, .tensors = {}, .unused = {}};
  RandomStream random(name.size());
  weights.tensors = random_tensors(required_tensors(description), random, -0.3, 0.3);
  write_safetensors(path, to_weight_file(weights));
}

TEST_F(EvaluateCommandTest, RunsAndShippedModelsAreRows) {
  for (const std::string name : {"no-box", "blind"}) {
    fs::create_directories(folder_ / "runs" / name);
    write_network(folder_ / "runs" / name / "best.safetensors", name);
  }
  fs::create_directories(folder_ / "runs/unfinished");
  const auto methods_of = [](const ProgramOutcome& outcome) {
    std::vector<std::string> names;
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    if (outcome.exit_code != 0) return names;
    const auto json = nlohmann::json::parse(outcome.output);
    for (const auto& row : json.at("rows")) {
      names.push_back(row.at("method"));
      EXPECT_GT(row.at("mag").at("mean"), 0.0);
    }
    return names;
  };
  const std::vector<std::string> few{"--limit", "2", "--json"};
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.end(), few.begin(), few.end());
    return evaluate(folder_ / "data", words);
  };
  EXPECT_EQ(methods_of(with({"--ablations", "--runs", (folder_ / "runs").string()})),
            (std::vector<std::string>{"input", "blind", "no-box"}));

  fs::create_directories(folder_ / "models");
  write_network(folder_ / "models/vigas.safetensors", "vigas");
  write_network(folder_ / "models/vigas-blind.safetensors", "vigas-blind");
  write_gtf_file(folder_ / "models/gtf.safetensors");
  write_gtf_file(folder_ / "models/gtf-no-3d.safetensors", 32, false);
  write_gtf_file(folder_ / "models/other.safetensors");
  ::setenv("EARPOINT_MODELS_DIR", (folder_ / "models").c_str(), 1);
  EXPECT_EQ(methods_of(with({"--ablations"})),
            (std::vector<std::string>{"input", "gtf", "gtf-no-3d", "vigas", "vigas-blind"}));
  EXPECT_EQ(methods_of(with({"--methods", "vigas"})), (std::vector<std::string>{"vigas"}));
  ::setenv("EARPOINT_MODELS_DIR", folder_.c_str(), 1);
  const ProgramOutcome none = with({"--ablations"});
  ::unsetenv("EARPOINT_MODELS_DIR");
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.errors.find("neither gtf.safetensors nor"), std::string::npos) << none.errors;
}

TEST_F(EvaluateCommandTest, ATextureIsAskedForAfterAColon) {
  write_gtf_file(folder_ / "two.safetensors", 32, true, true);
  const std::string file = (folder_ / "two.safetensors").string();
  const ProgramOutcome outcome =
      evaluate(folder_ / "data", {"--methods",
                                  "two=" + file + ",two=" + file + ":natural,two=" + file +
                                      ":mean,two=" + file + ":0,two=" + file + ":0.5",
                                  "--limit", "2", "--quiet", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const nlohmann::json rows = nlohmann::json::parse(outcome.output).at("rows");
  const auto mag = [&](std::size_t row) { return rows.at(row).at("mag"); };
  EXPECT_EQ(rows.at(2).at("method"), "two:mean");
  EXPECT_EQ(mag(0), mag(1));
  EXPECT_NE(mag(0), mag(2));
  EXPECT_EQ(mag(2), mag(3));
  EXPECT_EQ(rows.at(4).at("method"), "two:0.5");
  EXPECT_NE(mag(0), mag(4));
  EXPECT_NE(mag(2), mag(4));
  const ProgramOutcome refused =
      evaluate(folder_ / "data", {"--methods", "two=" + file + ":2", "--quiet"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.errors.find("two.safetensors:2"), std::string::npos) << refused.errors;
}

TEST_F(EvaluateCommandTest, SaysThatNobodyHearsReverberationTimes) {
  const ProgramOutcome outcome =
      run_earpoint({"evaluate", "--data", (folder_ / "data").string(), "--methods", "input",
                    "--limit", "2", "--quiet", "--json"},
                   {"EARPOINT_MODELS_DIR=" + folder_.string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("found no rt60.safetensors"), std::string::npos) << outcome.errors;
  EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
  EXPECT_FALSE(nlohmann::json::parse(outcome.output).at("rows").at(0).contains("rte_s"));
}

TEST_F(EvaluateCommandTest, ReportIsWritten) {
  const ProgramOutcome outcome =
      evaluate(folder_ / "data",
               {"--methods", "input", "--limit", "2", "--report", (folder_ / "page").string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_GT(fs::file_size(folder_ / "page/index.html"), 100000U);
}

TEST_F(EvaluateCommandTest, FigureShowsASourceItsTargetsAndTheVoice) {
  const fs::path figure = folder_ / "figure.svg";
  const ProgramOutcome outcome = evaluate(
      folder_ / "data",
      {"--methods", "input", "--clips", "home-0000/1:2,home-0000/2", "--figure", figure.string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.output, "");
  const std::string svg = read_text_file(figure);
  for (const char* title : {">Source<", ">Target 1<", ">Target 3<", ">Enhancement<", ">truth<"}) {
    EXPECT_NE(svg.find(title), std::string::npos) << title;
  }
  EXPECT_NE(svg.find("home-0000, clip 1"), std::string::npos);
  EXPECT_NE(svg.find("home-0000, clip 2"), std::string::npos);
}

TEST_F(EvaluateCommandTest, BadUseIsOneLine) {
  const auto error_of = [&](const std::vector<std::string>& more) {
    const ProgramOutcome outcome = evaluate(folder_ / "data", more);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    return outcome.errors;
  };
  EXPECT_NE(
      error_of({"--methods", "nothing-of-ours"}).find("name a weight file: nothing-of-ours=F"),
      std::string::npos);
  EXPECT_NE(error_of({"--methods", "input,input"}).find("names input twice"), std::string::npos);
  EXPECT_NE(error_of({"--methods", "=x"}).find("expected NAME=FILE"), std::string::npos);
  // This data set has no training split for tf.
  EXPECT_NE(error_of({"--methods", "tf"}).find("train: no such folder"), std::string::npos);
  EXPECT_NE(error_of({"--split", "val"}).find("val: no such folder"), std::string::npos);
  EXPECT_NE(error_of({"--runs", (folder_ / "speech").string()}).find("holds no run"),
            std::string::npos);
  EXPECT_NE(error_of({"--enhance", "--methods", "dsp"}).find("leave it out with --enhance"),
            std::string::npos);
  EXPECT_NE(error_of({"--pairs", "none.json"}).find("none.json"), std::string::npos);
  const std::string figure = (folder_ / "no.svg").string();
  EXPECT_NE(error_of({"--figure", "figure.png"}).find(".svg"), std::string::npos);
  EXPECT_NE(error_of({"--figure", figure, "--clips", "home-0000/9"}).find("no clip"),
            std::string::npos);
  EXPECT_NE(error_of({"--figure", figure, "--methods", "oracle-gain"}).find("oracle"),
            std::string::npos);
  EXPECT_NE(error_of({"--clips", "home-0000/1"}).find("--figure"), std::string::npos);
  EXPECT_FALSE(fs::exists(figure));
}

TEST(EvaluateRwavs, MeasuresEveryPoseByInputAndDsp) {
  const fs::path folder =
      fs::path(testing::TempDir()) / ("evaluate_rwavs." + std::to_string(::getpid()));
  fs::remove_all(folder);
  write_tiny_rwavs(folder);
  const auto evaluate = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"evaluate", "--data", folder.string(), "--quiet"});
    return run_earpoint(words);
  };
  const ProgramOutcome outcome = evaluate({"--split", "val", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json.at("pairs"), "every pose of the split");
  ASSERT_EQ(json.at("rows").size(), 2U) << outcome.output;
  EXPECT_NE(evaluate({}).errors.find("use --split val"), std::string::npos);
  for (const std::vector<std::string>& words : {std::vector<std::string>{"--methods", "gtf"},
                                                {"--methods", "tf"},
                                                {"--report", "out"},
                                                {"--figure", "clips.svg"},
                                                {"--boxes", "none"},
                                                {"--ambient", "-40"},
                                                {"--context", "1"}}) {
    std::vector<std::string> all{"--split", "val"};
    all.insert(all.end(), words.begin(), words.end());
    const ProgramOutcome refused = evaluate(all);
    EXPECT_EQ(refused.exit_code, 2) << words[0];
    EXPECT_EQ(std::count(refused.errors.begin(), refused.errors.end(), '\n'), 1) << refused.errors;
    EXPECT_NE(refused.errors.find("RWAVS"), std::string::npos) << refused.errors;
  }
  fs::remove_all(folder);
}

}  // namespace

}  // namespace earpoint
