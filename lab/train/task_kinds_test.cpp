#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/core/file.h>
#include <earpoint/dataset/people_pictures.h>
#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/error.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/media/image_file.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/people/weights.h>
#include <earpoint/rt60/weights.h>
#include <earpoint/train/initial_weights.h>
#include <earpoint/train/train_config.h>
#include <earpoint/train/trainer.h>
#include <earpoint/train/training_task.h>
#include <earpoint/vam/weights.h>
#include <earpoint/vigas/description.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRt60 = R"({"kind": "rt60", "channels": 2, "input_rms": 1.0})";
constexpr const char* kVam = R"({"kind": "vam", "image_width_px": 32, "image_height_px": 32,
  "trunk_channels": 2, "strides": [5, 4], "channels": [4, 6], "heads": 2,
  "feed_forward_width": 8})";

constexpr const char* kGtf = R"({"kind": "gtf", "channels": 8, "layers": 2, "bands": 8,
  "picture_px": 32, "loss": {"level": 0.5}})";

std::string config_of(const std::string& network, const std::string& data = "{}") {
  return R"({"format": "earpoint-train-1", "network": )" + network + R"(, "data": )" + data +
         R"(, "training": {"batch": 2, "steps": 2, "validate_every": 2}})";
}

class TaskKinds : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("task_kinds." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    write_tiny_dataset(folder_ / "data", {.response_s = 0.3});
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Trains to the end and returns the best weights.
  [[nodiscard]] SafetensorsFile trained(const std::string& text) const {
    const TrainConfig config = train_config_from_json(text, "config");
    const TrainingTask task =
        make_training_task(config, "config", {.data = folder_ / "data", .on_bad = {}});
    SilentProgress silent;
    const TrainingSummary summary = train(*task.learner, *task.examples,
                                          {.folder = folder_ / "run",
                                           .plan = config.training,
                                           .config = config.text,
                                           .on_validation = {}},
                                          nullptr, silent);
    EXPECT_EQ(summary.steps, 2);
    EXPECT_GT(summary.best_error, 0.0);
    return read_safetensors(folder_ / "run" / "best.safetensors");
  }

  [[nodiscard]] std::string refusal(const std::string& text,
                                    const SafetensorsFile* checkpoint = nullptr) const {
    try {
      const TrainConfig config = train_config_from_json(text, "config");
      (void)make_training_task(config, "config",
                               {.data = folder_ / "data", .on_bad = {}, .checkpoint = checkpoint});
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }

  fs::path folder_;
};

TEST_F(TaskKinds, TrainsAGeometricNetwork) {
  const GtfWeights weights = gtf_weights(
      trained(config_of(kGtf, R"({"any_speech": true, "window_samples": 8000})")), "best");
  EXPECT_EQ(weights.description.channels, 8);
  EXPECT_EQ(weights.description.window_samples, 8000);
  EXPECT_EQ(weights.description.highpass_cutoff_hz, 80.0);
}

TEST_F(TaskKinds, TrainsAGeometricNetworkForTwoTextures) {
  const GtfWeights weights = gtf_weights(trained(config_of(R"({"kind": "gtf", "channels": 8,
      "layers": 2, "bands": 8, "picture_px": 32, "phase_rounds": 1, "texture": true,
      "dry_voice": true, "loss": {"dry_voice": 0.1, "natural": {"decay": 0.01}}})")),
                                         "best");
  EXPECT_TRUE(weights.description.texture);
  EXPECT_EQ(weights.description.phase_rounds, 1);
  EXPECT_TRUE(weights.tensors.contains("dry.weight"));
}

TEST_F(TaskKinds, NamesWhatIsWrongWithAGeometricNetwork) {
  const auto said = [&](const char* network) { return refusal(config_of(network)); };
  EXPECT_NE(said(R"({"kind": "gtf", "loss": {"levels": 1}})").find("levels"), std::string::npos);
  EXPECT_NE(said(R"({"kind": "gtf", "loss": {"level": -1}})").find("'level': expected 0 to 1000"),
            std::string::npos);
  EXPECT_NE(said(R"({"kind": "gtf", "picture_px": 33})").find("multiple of 32"), std::string::npos);
  EXPECT_NE(said(R"({"kind": "gtf", "texture": true})").find("'texture' and 'loss.natural' need"),
            std::string::npos);
  EXPECT_NE(
      said(R"({"kind": "gtf", "loss": {"natural": {}}})").find("'texture' and 'loss.natural' need"),
      std::string::npos);
  EXPECT_NE(said(R"({"kind": "gtf", "texture": true, "loss": {"natural": {"levels": 1}}})")
                .find("'loss': 'natural'"),
            std::string::npos);
  EXPECT_NE(said(R"({"kind": "gtf", "loss": {"dry_voice": 1}})").find("'loss.dry_voice' needs"),
            std::string::npos);
}

TEST_F(TaskKinds, ShippedConfigurationsOfGeometricNetworksCanStart) {
  const fs::path configs = fs::path(EARPOINT_SOURCE_DIR) / "configs";
  // Ablations as ./dev results trains them.
  const std::vector<std::vector<ConfigSetting>> ablations{
      {},
      {{"network.picture_px", "0"}, {"network.box", "false"}},
      {{"network.picture_px", "0"}},
      {{"network.geometry", "false"},
       {"network.expected_level", "false"},
       {"network.delays", "false"},
       {"network.ear_delays", "false"}},
      {{"network.delays", "false"}, {"network.ear_delays", "false"}},
      {{"network.tails_s", "[]"}}};
  for (const char* name : {"gtf.json", "enhance.json"}) {
    for (const std::vector<ConfigSetting>& ablation : ablations) {
      const TrainConfig config = read_train_config(configs / name, ablation);
      EXPECT_EQ(config.kind, "gtf");
      EXPECT_NO_THROW(static_cast<void>(
          make_training_task(config, name, {.data = folder_ / "data", .on_bad = {}})))
          << name << " " << (ablation.empty() ? "" : ablation[0].key);
    }
  }
}

TEST_F(TaskKinds, TrainingOnKeepsTheRangeOfTheWeightsUnlessTheConfigurationHasOne) {
  const auto weights_of = [&](const std::string& more) {
    const std::string text = config_of(
        R"({"kind": "gtf", "channels": 8, "layers": 2, "bands": 8, "picture_px": 32)" + more + "}");
    return make_training_task(train_config_from_json(text, "c.json"), "c.json",
                              {.data = folder_ / "data", .on_bad = {}})
        .learner->weight_file();
  };
  const fs::path first = folder_ / "first.safetensors";
  write_safetensors(first, weights_of(R"(, "training_range": {"farthest_move_m": 8})"));
  const std::string init = R"(, "init": ")" + first.string() + "\"";
  const auto farthest_m = [&](const std::string& more) {
    return gtf_weights(weights_of(init + more), "now").description.training_range.farthest_move_m;
  };
  EXPECT_EQ(farthest_m(""), 8.0);
  EXPECT_EQ(farthest_m(R"(, "training_range": {"farthest_move_m": 6})"), 6.0);
}

TEST_F(TaskKinds, TrainsAGeometricNetworkByAnEstimatorsEar) {
  const fs::path estimator = folder_ / "estimator.safetensors";
  write_safetensors(estimator, to_weight_file(initial_rt60_weights({2, 1.0}, 1)));
  const auto config = [&](const std::string& path, const std::string& data) {
    return config_of(R"({"kind": "gtf", "channels": 8, "layers": 2, "bands": 8, "picture_px": 32,
      "loss": {"reverberation": 1}, "estimator": ")" +
                         path + R"("})",
                     data);
  };
  EXPECT_EQ(gtf_weights(trained(config(estimator, "{}")), "best").description.channels, 8);

  fs::resize_file(estimator, 100);
  EXPECT_NE(refusal(config(estimator, "{}")).find("estimator.safetensors"), std::string::npos);
  write_safetensors(estimator, to_weight_file(initial_rt60_weights({2, 1.0}, 1)));
  EXPECT_NE(refusal(config(estimator, R"({"window_samples": 8000})")).find("16000 samples"),
            std::string::npos);
  EXPECT_NE(refusal(config_of(R"({"kind": "gtf", "loss": {"reverberation": 1}})"))
                .find("'loss.reverberation' and 'estimator' need each other"),
            std::string::npos);
}

TEST_F(TaskKinds, RefusesStepsThatWouldLearnNothing) {
  EXPECT_NE(refusal(config_of(R"({"kind": "vigas", "place_steps": 3})"))
                .find("'place': expected more than 0"),
            std::string::npos);
  EXPECT_NE(refusal(config_of(R"({"kind": "gtf", "place_steps": 3, "loss": {"place": 0}})"))
                .find("'place_steps' needs the loss of the position"),
            std::string::npos);
  EXPECT_NE(refusal(config_of(R"({"kind": "gtf", "place_steps": 3, "geometry": false,
      "delays": false})"))
                .find("'place_steps' needs a network that locates the speaker"),
            std::string::npos);
  EXPECT_NE(refusal(config_of(R"({"kind": "gtf", "place_steps": -1})"))
                .find("'place_steps': expected a whole number"),
            std::string::npos);
}

TEST(ViGasExample, SaysWhereTheSpeakerIsFromTheTarget) {
  PairSample sample;
  sample.source = Waveform(2, 16000, 16000);
  sample.target = Waveform(2, 16000, 16000);
  sample.speaker_m = {2, 0, 0};
  // Beside the speaker, 1 m to the left as seen from the source, and turned to the right.
  sample.source_from_target = {{2, 1, 0}, quaternion_from_euler({.yaw_rad = -0.5 * kPi})};
  ViGasDescription d;
  d.pose_encoding = PoseEncoding::full;
  d.inputs = {{"tgt_pose", 3}, {"tgt_rotation", 6}};
  const std::vector<float> place = vigas_example(d, sample).inputs.at("place");
  ASSERT_EQ(place.size(), 4U);
  EXPECT_NEAR(place[0], 1.0, 1e-6);  // straight ahead
  EXPECT_NEAR(place[1], 0.0, 1e-6);
  EXPECT_NEAR(place[2], 0.0, 1e-6);             // at 1 m
  EXPECT_NEAR(place[3], -std::log(2.0), 1e-6);  // half as far as from the source
  // With the head turned back by 90 degrees, the speaker is to the right.
  sample.source_from_target.orientation = {};
  EXPECT_NEAR(vigas_example(d, sample).inputs.at("place")[1], -1.0, 1e-6);
}

TEST_F(TaskKinds, TrainsAnEstimatorOfReverberationTime) {
  const Rt60EstimatorWeights weights =
      rt60_estimator_weights(trained(config_of(kRt60, R"({"validation_seconds": 3})")), "best");
  EXPECT_EQ(weights.description.channels, 2);
  EXPECT_EQ(weights.description.input_rms, 1.0);
}

TEST_F(TaskKinds, TrainsANetworkThatFindsPeople) {
  for (const char* split : {"train", "val"}) {
    const fs::path home = folder_ / "data" / split / "home-0000";
    fs::create_directories(home);
    write_image(home / "a.png", Image(80, 48, 3, 100));
    const Box box{.x_min = 0.2, .y_min = 0.1, .x_max = 0.5, .y_max = 0.9};
    const std::vector<PeoplePicture> pictures{{home / "a.png", {{box, 1.0}}}};
    write_file(home / kPeoplePictureList, people_picture_list(pictures));
  }
  const std::string network = R"({"kind": "people", "longest_px": 64, "channels": 2})";
  const PeopleWeights weights = people_weights(
      trained(config_of(network, R"({"view_width_px": 64, "view_height_px": 32})")), "best");
  EXPECT_EQ(weights.description.channels, 2);
  EXPECT_EQ(weights.description.longest_px, 64);
  EXPECT_NE(refusal(config_of(network, R"({"view_width_px": 60})"))
                .find("'view_width_px': expected a multiple of 32"),
            std::string::npos);
}

TEST_F(TaskKinds, TrainsVisualAcousticMatching) {
  const VamWeights weights =
      vam_weights(trained(config_of(kVam, R"({"validation_pairs": 2})")), "best");
  EXPECT_EQ(weights.description.width(), 6);
  EXPECT_EQ(weights.description.highpass_cutoff_hz, 80.0);  // it learns separated sound
}

TEST_F(TaskKinds, ExamplesDependOnTheirNumberAlone) {
  const TrainConfig config = train_config_from_json(config_of(kRt60), "config");
  const TrainingTask task =
      make_training_task(config, "config", {.data = folder_ / "data", .on_bad = {}});
  EXPECT_EQ(task.examples->training(5).source, task.examples->training(5).source);
  EXPECT_NE(task.examples->training(5).source, task.examples->training(6).source);
  EXPECT_EQ(task.examples->validations(), 2U * 3U * 2U * 2U);  // one for every ear's response
}

TEST_F(TaskKinds, WrongKeysAreNamed) {
  EXPECT_NE(refusal(config_of(R"({"kind": "rt60", "width": 2})")).find("width"), std::string::npos);
  EXPECT_NE(refusal(config_of(R"({"kind": "rt60", "format": 1})")).find("format"),
            std::string::npos);
  EXPECT_NE(refusal(config_of(kRt60, R"({"responses": 0})")).find("responses"), std::string::npos);
  EXPECT_NE(refusal(config_of(R"({"kind": "vam", "heads": 5})")).find("heads"), std::string::npos);
  EXPECT_NE(refusal(config_of(R"({"kind": "gan"})")).find("found \"gan\""), std::string::npos);
}

TEST_F(TaskKinds, DoesNotGoOnWithAnotherNetwork) {
  const TrainConfig config = train_config_from_json(config_of(kRt60), "config");
  const TrainingTask task =
      make_training_task(config, "config", {.data = folder_ / "data", .on_bad = {}});
  const SafetensorsFile checkpoint = [&] {
    (void)task.learner->compute_gradients(
        join(std::vector{task.examples->training(0), task.examples->training(1)}));
    task.learner->apply_gradients(1e-3);
    return task.learner->checkpoint();
  }();
  EXPECT_EQ(refusal(config_of(kRt60), &checkpoint), "accepted");
  EXPECT_NE(refusal(config_of(R"({"kind": "rt60", "channels": 3})"), &checkpoint)
                .find("different network"),
            std::string::npos);
}

}  // namespace
}  // namespace earpoint
