#include "run_program.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

const std::string kOracle = EARPOINT_SOURCE_DIR "/src/networks/vigas/testdata/C_mini_noresnet";

class ModelRunCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(testing::TempDir()) / ("model_run_command_" + name);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    weights_ = (folder_ / "mini.safetensors").string();
    output_ = (folder_ / "outputs.safetensors").string();
    const ProgramOutcome imported =
        run_earpoint({"model", "import", kOracle + "/best_val.ckpt", "-o", weights_});
    ASSERT_EQ(imported.exit_code, 0) << imported.errors;
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] static SafetensorsFile oracle_inputs() {
    return read_safetensors(kOracle + "/inputs.safetensors");
  }

  /// Exit 2, one line on standard error, nothing written.
  void expect_refused(const SafetensorsFile& inputs, const std::string& part) {
    const std::string path = (folder_ / "inputs.safetensors").string();
    write_safetensors(path, inputs);
    const ProgramOutcome outcome = run_earpoint({"model", "run", weights_, path, "-o", output_});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
    EXPECT_NE(outcome.errors.find(part), std::string::npos) << outcome.errors;
    EXPECT_FALSE(fs::exists(output_));
  }

  fs::path folder_;
  std::string weights_;
  std::string output_;
};

double largest_difference(const Tensor& a, const Tensor& b) {
  EXPECT_EQ(a.shape, b.shape);
  double largest = 0.0;
  for (std::size_t i = 0; i < a.as<float>().size(); ++i) {
    largest = std::max(largest, std::abs(static_cast<double>(a.as<float>()[i]) - b.as<float>()[i]));
  }
  return largest;
}

TEST_F(ModelRunCommand, WritesWhatTheReleasedCodeWrote) {
  const ProgramOutcome outcome = run_earpoint(
      {"model", "run", weights_, kOracle + "/inputs.safetensors", "-o", output_, "--threads", "1"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.output, "");
  const SafetensorsFile found = read_safetensors(output_);
  const SafetensorsFile expected = read_safetensors(kOracle + "/outputs.safetensors");
  // Four float32 layers with values of order 1.
  EXPECT_LT(largest_difference(found.tensors.at("pred"), expected.tensors.at("pred")), 5e-6);
  EXPECT_LT(largest_difference(found.tensors.at("fused"), expected.tensors.at("fused")), 5e-6);
  EXPECT_EQ(found.tensors.at("visual_feat"), oracle_inputs().tensors.at("visual_feat"));
  EXPECT_EQ(found.tensors.size(), 3U);
}

TEST_F(ModelRunCommand, ThreadsDoNotChangeAByte) {
  const std::string other = (folder_ / "other.safetensors").string();
  for (const auto& [threads, path] : {std::pair("1", output_), std::pair("3", other)}) {
    const ProgramOutcome outcome =
        run_earpoint({"model", "run", weights_, kOracle + "/inputs.safetensors", "-o", path,
                      "--threads", threads});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  }
  EXPECT_EQ(read_file(output_), read_file(other));
}

TEST_F(ModelRunCommand, WrongTensorsGiveOneLineAndNoOutput) {
  SafetensorsFile inputs = oracle_inputs();
  inputs.tensors.erase("bboxes");
  expect_refused(inputs, "inputs.safetensors: has no tensor 'bboxes'");

  inputs = oracle_inputs();
  inputs.tensors["tgt_pose"].shape = {3, 2};
  expect_refused(inputs, "tensor 'tgt_pose': expected F32 [2, 3], found F32 [3, 2]");

  inputs = oracle_inputs();
  inputs.tensors["src_wav"] = make_tensor<float>(std::vector<float>{}, {0, 2, 5});
  expect_refused(inputs, "expected at least one clip of one sample, found [0, 2, 5]");

  inputs = oracle_inputs();
  inputs.tensors["src_wav"].shape = {4, 1, 1600};
  expect_refused(inputs, "expected F32 [any, 2, any], found F32 [4, 1, 1600]");

  inputs = oracle_inputs();
  std::vector<float> boxes(8, 0.5F);
  boxes[3] = NAN;
  inputs.tensors["bboxes"] = make_tensor<float>(boxes, {2, 4});
  expect_refused(inputs, "tensor 'bboxes': has NaN or infinite values");
}

}  // namespace

}  // namespace earpoint
