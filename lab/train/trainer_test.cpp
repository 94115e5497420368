#include <algorithm>
#include <csignal>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <earpoint/core/file.h>
#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>
#include <earpoint/train/trainer.h>
#include <earpoint/train/training_task.h>
#include <earpoint/vigas/weights.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

std::string tiny_config(const std::string& training) {
  return R"({"format": "earpoint-train-1",
 "network": {"kind": "vigas", "blocks": 1, "layers_per_block": 3, "channels": 8, "fusion_width": 16,
             "conditioning_width": 8, "picture": null, "init": "identity"},
 "data": {"window_samples": 4000, "validation_pairs": 4},
 "training": {"batch": 2, )" +
         training + "}}";
}

/// Throws when the given step is taken.
class StopAtStep : public SilentProgress {
 public:
  explicit StopAtStep(int step) : left_(step) {}
  void advance(double /*amount*/) override {
    if (--left_ == 0) throw std::runtime_error("stopped");
  }

 private:
  int left_;
};

class TrainerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("trainer." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    write_tiny_dataset(folder_ / "data");
    set_learner_threads(1);
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Trains, from the folder's checkpoint if there is one.
  TrainingSummary run(const std::string& name, const std::string& training,
                      const std::function<void(const ValidationResult&)>& watch = {}) const {
    SilentProgress silent;
    TrainerOptions options;
    options.on_validation = watch;
    return run(name, training, silent, options);
  }

  /// @param trainer  its folder, plan, configuration and workers are set here
  TrainingSummary run(const std::string& name, const std::string& training, ProgressSink& progress,
                      TrainerOptions trainer) const {
    const TrainConfig config = train_config_from_json(tiny_config(training), "config");
    const auto checkpoint = read_checkpoint(folder_ / name, config.text);
    TaskOptions options{.data = folder_ / "data", .on_bad = {}};
    options.checkpoint = checkpoint ? &*checkpoint : nullptr;
    const TrainingTask task = make_training_task(config, "config", options);
    trainer.folder = folder_ / name;
    trainer.plan = config.training;
    trainer.config = config.text;
    trainer.workers = 2;
    return train(*task.learner, *task.examples, trainer, options.checkpoint, progress);
  }

  [[nodiscard]] std::string text(const std::string& path) const {
    return read_text_file(folder_ / path);
  }

  fs::path folder_;
};

TEST_F(TrainerTest, TwoProcessesDoNotTrainInOneFolder) {
  std::optional<RunLock> first(folder_ / "run");
  try {
    const RunLock second(folder_ / "run");
    FAIL() << "expected InputError";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("another process is training there"),
              std::string::npos);
  }
  first.reset();
  EXPECT_NO_THROW(RunLock(folder_ / "run"));
}

TEST_F(TrainerTest, LearnsAndKeepsTheBestWeights) {
  std::vector<double> errors;
  const TrainingSummary summary =
      run("run", R"("steps": 60, "validate_every": 20)",
          [&](const ValidationResult& result) { errors.push_back(result.error); });
  ASSERT_EQ(errors.size(), 4U);  // before the first step, too
  EXPECT_EQ(summary.first_error, errors[0]);
  EXPECT_EQ(summary.best_error, *std::ranges::min_element(errors));
  EXPECT_LT(summary.best_error, 0.97 * summary.first_error);
  EXPECT_EQ(summary.clips, 120);
  EXPECT_EQ(summary.end, TrainingEnd::steps);
  EXPECT_GT(summary.clips_per_s, 0.0);
  // The best weights are a network that has that error.
  ViGasLearner best(read_vigas_weights(folder_ / "run/best.safetensors"));
  const TrainConfig config = train_config_from_json(tiny_config(R"("steps": 1)"), "config");
  const TrainingTask task =
      make_training_task(config, "config", {.data = folder_ / "data", .on_bad = {}});
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const TrainingExample example = *task.examples->validation(i);
    sum += best.errors(join({&example, 1}))[0];
  }
  EXPECT_NEAR(sum / 4.0, summary.best_error, 1e-6 * summary.best_error);
  EXPECT_EQ(read_image(folder_ / "run/curves.png").width(), 900);
  EXPECT_EQ(std::ranges::count(text("run/steps.csv"), '\n'), 61);
}

TEST_F(TrainerTest, ARunThatWasKilledGoesOnAsIfItHadNotBeen) {
  const std::string plan = R"("steps": 12, "validate_every": 4, "schedule": "cosine")";
  run("whole", plan);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    // Killed within the eighth step's validation: the checkpoint of the fourth is the last.
    int validations = 0;
    run("killed", plan, [&](const ValidationResult&) {
      if (++validations == 2) ::kill(::getpid(), SIGKILL);
    });
    ::_exit(1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  // A killed process may leave lines after the last checkpoint, and half a line.
  const std::string steps = text("killed/steps.csv");
  EXPECT_EQ(std::ranges::count(steps, '\n'), 5);
  write_file(folder_ / "killed/steps.csv", steps + "5,123,0.1\n6,12");
  run("killed", plan);
  EXPECT_EQ(text("killed/steps.csv"), text("whole/steps.csv"));
  EXPECT_TRUE(read_vigas_weights(folder_ / "killed/best.safetensors").tensors ==
              read_vigas_weights(folder_ / "whole/best.safetensors").tensors);
}

TEST_F(TrainerTest, SavesBetweenValidations) {
  const std::string plan = R"("steps": 6, "validate_every": 100, "schedule": "cosine")";
  run("whole", plan);
  StopAtStep progress(4);
  TrainerOptions at_every_step;
  at_every_step.save_every_s = 0.0;
  EXPECT_THROW(run("stopped", plan, progress, at_every_step), std::runtime_error);
  // The fourth step is in the log, but not in the checkpoint.
  EXPECT_EQ(std::ranges::count(text("stopped/steps.csv"), '\n'), 5);
  const SafetensorsFile checkpoint =
      read_safetensors(folder_ / "stopped" / "checkpoint.safetensors");
  EXPECT_NE(checkpoint.metadata.at("earpoint.training").find(R"("step":3)"), std::string::npos);
  run("stopped", plan);
  EXPECT_EQ(text("stopped/steps.csv"), text("whole/steps.csv"));
  EXPECT_TRUE(read_vigas_weights(folder_ / "stopped/checkpoint.safetensors").tensors ==
              read_vigas_weights(folder_ / "whole/checkpoint.safetensors").tensors);
}

TEST_F(TrainerTest, ResumeRefusesAnotherConfigurationButAllowsMoreSteps) {
  run("run", R"("steps": 2, "validate_every": 1)");
  EXPECT_EQ(run("run", R"("steps": 3, "validate_every": 1)").steps, 3);
  EXPECT_THROW(run("run", R"("steps": 3, "validate_every": 2)"), InputError);
}

TEST_F(TrainerTest, EndsWhenNothingImprovesAndWhenTimeIsUp) {
  // At this rate the second step undoes the first.
  const TrainingSummary tired =
      run("tired", R"("steps": 500, "validate_every": 1, "patience": 3, "learning_rate": 0.5)");
  EXPECT_EQ(tired.end, TrainingEnd::patience);
  EXPECT_EQ(tired.steps, tired.best_step + 3);
  const TrainingSummary late =
      run("late", R"("steps": 1000000, "validate_every": 1000000, "minutes": 0.01)");
  EXPECT_EQ(late.end, TrainingEnd::minutes);
}

TEST_F(TrainerTest, KeepsTheLastWeightsWhereToldTo) {
  // At this rate every step after the first increases the error.
  const std::string plan = R"("steps": 4, "validate_every": 1, "learning_rate": 0.5)";
  const TrainingSummary best = run("best", plan);
  ASSERT_LT(best.best_step, 4);
  run("last", plan + R"(, "keep": "last")");
  const auto weights = [&](const std::string& name) {
    return read_vigas_weights(folder_ / name).tensors;
  };
  EXPECT_FALSE(weights("best/best.safetensors") == weights("last/best.safetensors"));
  EXPECT_TRUE(weights("last/best.safetensors") == weights("last/checkpoint.safetensors"));
}

}  // namespace
}  // namespace earpoint
