#include "gtf_file.h"
#include "run_program.h"

#include <algorithm>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

const std::string kCheckpoint =
    EARPOINT_SOURCE_DIR "/src/networks/vigas/testdata/C_mini_noresnet/best_val.ckpt";

class ModelCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(testing::TempDir()) / ("model_command_" + name);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    output_ = (folder_ / "mini.safetensors").string();
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Exit 2, one line on standard error, nothing written.
  void expect_refused(const std::vector<std::string>& arguments, const std::string& part) {
    const ProgramOutcome outcome = run_earpoint(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    EXPECT_NE(outcome.errors.find(part), std::string::npos) << outcome.errors;
    EXPECT_FALSE(fs::exists(output_));
  }

  fs::path folder_;
  std::string output_;
};

TEST_F(ModelCommand, ImportsACheckpointThatInfoDescribes) {
  const ProgramOutcome imported = run_earpoint({"model", "import", kCheckpoint, "-o", output_});
  EXPECT_EQ(imported.exit_code, 0) << imported.errors;
  EXPECT_NE(imported.output.find("dropped 14 tensors"), std::string::npos) << imported.output;

  const ProgramOutcome info = run_earpoint({"model", "info", output_, "--json"});
  EXPECT_EQ(info.exit_code, 0) << info.errors;
  const nlohmann::json json = nlohmann::json::parse(info.output);
  EXPECT_EQ(json.at("description").at("network"), "vigas");
  EXPECT_EQ(json.at("description").at("channels"), 8);
  EXPECT_EQ(json.at("unused_tensors").size(), 0U);

  const ProgramOutcome text = run_earpoint({"model", "info", output_});
  EXPECT_NE(text.output.find("pose_encoding        soundspaces\n"), std::string::npos)
      << text.output;
}

TEST_F(ModelCommand, KeepAllKeepsEverything) {
  const ProgramOutcome imported =
      run_earpoint({"model", "import", kCheckpoint, "-o", output_, "--keep-all"});
  EXPECT_EQ(imported.exit_code, 0) << imported.errors;
  const ProgramOutcome info = run_earpoint({"model", "info", output_, "--json"});
  EXPECT_EQ(nlohmann::json::parse(info.output).at("unused_tensors").size(), 14U);
}

TEST_F(ModelCommand, ExportMakesACheckpointThatImportReadsBack) {
  ASSERT_EQ(run_earpoint({"model", "import", kCheckpoint, "-o", output_, "--keep-all"}).exit_code,
            0);
  const std::string checkpoint = (folder_ / "again.ckpt").string();
  const ProgramOutcome exported = run_earpoint({"model", "export", output_, "-o", checkpoint});
  EXPECT_EQ(exported.exit_code, 0) << exported.errors;
  EXPECT_NE(exported.output.find("70 tensors, 146 options"), std::string::npos) << exported.output;
  // The released class has 64 channels.
  EXPECT_NE(exported.errors.find("channels: 64 there, 8 here"), std::string::npos)
      << exported.errors;
  const std::string again = (folder_ / "again.safetensors").string();
  ASSERT_EQ(run_earpoint({"model", "import", checkpoint, "-o", again, "--keep-all"}).exit_code, 0);
  EXPECT_EQ(read_text_file(again), read_text_file(output_));
}

TEST_F(ModelCommand, SetRangeChangesTheTrainingRangeAndNoTensor) {
  const std::string gtf = (folder_ / "gtf.safetensors").string();
  write_gtf_file(gtf);
  ASSERT_EQ(run_earpoint(
                {"model", "set-range", gtf, "--range", R"({"farthest_move_m": 8})", "-o", output_})
                .exit_code,
            0);
  const ProgramOutcome info = run_earpoint({"model", "info", output_, "--json"});
  const nlohmann::json range = nlohmann::json::parse(info.output).at("training_range");
  EXPECT_EQ(range.at("farthest_move_m"), 8.0);
  EXPECT_EQ(range.at("farthest_speaker_m"), 4.0);
  EXPECT_EQ(read_safetensors(output_).tensors, read_safetensors(gtf).tensors);
  fs::remove(output_);
  expect_refused({"model", "set-range", gtf, "--range", R"({"nearest_m": 8})", "-o", output_},
                 "--range: unknown key 'nearest_m'");
}

TEST_F(ModelCommand, BadFilesGiveOneLineAndNoOutput) {
  expect_refused({"model", "import", "/missing.ckpt", "-o", output_},
                 "earpoint: /missing.ckpt: no such file");
  const std::string text = (folder_ / "text.ckpt").string();
  write_file(text, "not a checkpoint");
  expect_refused({"model", "import", text, "-o", output_}, "is not a complete zip archive");
  expect_refused({"model", "info", text}, "safetensors");
  expect_refused({"model", "info", kCheckpoint}, "safetensors");
  expect_refused(
      {"model", "info",
       EARPOINT_SOURCE_DIR "/src/networks/vigas/testdata/C_mini_noresnet/inputs.safetensors"},
      "has no metadata 'earpoint.network'; make it with earpoint model import");
  expect_refused({"model", "import", kCheckpoint, "-o", (folder_ / "no" / "x").string()},
                 "its folder does not exist");
}

}  // namespace

}  // namespace earpoint
