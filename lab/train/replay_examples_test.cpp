#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/dataset/replay_pair.h>
#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/error.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/network/weights.h>
#include <earpoint/train/training_task.h>
#include <earpoint/vigas/checkpoint_export.h>
#include <earpoint/vigas/description.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// Both data sets as they are downloaded, tiny, under one root.
class ReplayExamplesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("replay_examples." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    // Of the training and of the validation split.
    write_tiny_replay_dataset(folder_, {"SC-1022/0", "SC-1023/4", "SC-1026/2"});
    write_published_dataset(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] PairOptions options(Alignment alignment) const {
    PairOptions options;
    options.data = folder_;
    options.layout = DatasetLayout::replay;
    options.alignment = alignment;
    options.mirror = false;
    return options;
  }

  static TrainingExample pose_of(const PairSample& sample) {
    ViGasDescription description;
    description.pose_encoding = PoseEncoding::replay;
    return vigas_example(description, sample);
  }

  [[nodiscard]] std::string refusal(const std::string& json, DatasetLayout layout) const {
    try {
      const TrainConfig config = train_config_from_json(json, "c.json");
      TaskOptions options;
      options.data = folder_;
      options.layout = layout;
      static_cast<void>(make_training_task(config, "c.json", options));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }

  fs::path folder_;
};

TEST_F(ReplayExamplesTest, ExamplesAreTheLoadersNumbers) {
  const ReplayExamples examples(options(Alignment::none), pose_of);
  const ReplayDataset dataset(replay_options(folder_, "train"));
  bool from_first = false;
  bool from_second = false;
  for (std::uint64_t number = 0; number < 8; ++number) {
    const TrainingExample example = examples.training(number);
    // Which pair it is tells the height of the loader's first number.
    int matches = 0;
    for (int source = 0; source < 2; ++source) {
      const NvasSample sample = dataset.sample(dataset.clips()[0], {source, 1 - source}, false);
      const auto near = [](const std::vector<float>& found, const std::vector<double>& wanted) {
        return std::ranges::equal(found, wanted, [](float a, double b) {
          return std::abs(a - b) < 1e-3;  // float rounding of hundreds of centimetres
        });
      };
      if (!near(example.inputs.at("tgt_pose"), sample.tgt_pose)) continue;
      EXPECT_TRUE(near(example.inputs.at("tgt_rotation"), sample.tgt_rotation));
      ++matches;
      (source == 0 ? from_first : from_second) = true;
    }
    EXPECT_EQ(matches, 1) << number;
  }
  EXPECT_TRUE(from_first && from_second);
}

TEST_F(ReplayExamplesTest, AlignmentMovesTheSourceToTheTarget) {
  // Camera 2 has all sound 20 samples later; both have the same band-pass, whose start and end
  // differ.
  const auto distance = [&](Alignment alignment) {
    const TrainingExample example = ReplayExamples(options(alignment), pose_of).training(1);
    double sum = 0.0;
    for (std::size_t i = 1000; i < 15000; ++i) {
      sum += std::abs(example.source[i] - example.target[i]);
    }
    return sum;
  };
  EXPECT_LT(distance(Alignment::gcc_phat), 0.05 * distance(Alignment::none));
}

TEST_F(ReplayExamplesTest, ValidatesOnTheHeldOutScenes) {
  const ReplayExamples examples(options(Alignment::gcc_phat), pose_of);
  EXPECT_EQ(examples.validations(), 1U);
  EXPECT_TRUE(examples.validation(0).has_value());
}

TEST_F(ReplayExamplesTest, WhatRecordingsDoNotTellIsRefused) {
  const std::string training = R"(, "training": {"steps": 1, "batch": 1}})";
  const auto with = [&](const std::string& network, const std::string& data) {
    return R"({"format": "earpoint-train-1", "network": )" + network + R"(, "data": )" + data +
           training;
  };
  const auto replay = DatasetLayout::replay;
  const std::string vigas = R"({"kind": "vigas", "pose_encoding": "replay", "picture": null})";
  EXPECT_EQ(refusal(with(vigas, R"({"align": "gcc_phat"})"), replay), "accepted");
  EXPECT_NE(refusal(with(vigas, "{}"), replay).find("'align': expected \"gcc_phat\""),
            std::string::npos);
  EXPECT_NE(
      refusal(with(vigas, R"({"align": "none", "ambient_db": -40})"), replay).find("'ambient_db'"),
      std::string::npos);
  EXPECT_NE(
      refusal(with(R"({"kind": "vigas", "picture": null, "place": 0.1})", R"({"align": "none"})"),
              replay)
          .find("'place'"),
      std::string::npos);
}

/// Gives each clip a near microphone: camera 1's left ear, 30 samples earlier and half as loud.
void write_near_sounds(const fs::path& folder, const std::vector<std::string>& clips) {
  for (const std::string& clip : clips) {
    const fs::path place = folder / "data/appen_dataset/v3" / clip;
    const Waveform heard = read_sound(place / "1.wav");
    Waveform near(1, heard.samples(), heard.sample_rate_hz());
    for (std::ptrdiff_t i = 0; i + 30 < near.samples(); ++i) {
      near.channel(0)[i] = 0.5F * heard.channel(0)[i + 30];
    }
    write_sound(place / "near.wav", near);
  }
}

TEST_F(ReplayExamplesTest, TheNearMicrophoneStandsForDrySpeechOnTimeAndAsLoudAsTheSource) {
  write_near_sounds(folder_, {"SC-1022/0"});
  const ReplayDataset dataset(replay_options(folder_, "train"));
  const ReplayClip& clip = dataset.clips()[0];
  // The ears of camera 1 have independent noise; the left one is that of the near microphone.
  const ReplaySampler sampler(dataset, 0);
  const PairSample sample = sampler.sample(clip, {0, 1}, false);
  const Waveform voice = sampler.near_voice(clip, sample.source);
  double difference = 0.0;
  double level = 0.0;
  for (std::size_t i = 1000; i < 15000; ++i) {
    const double left = sample.source.channel(0)[i];
    difference += std::pow(voice.channel(0)[i] - left, 2);
    level += left * left;
  }
  // The level match differs by chance between ears, by a hundredth or so in amplitude. One sample
  // of delay would be a different noise.
  EXPECT_LT(difference, 1e-3 * level);
}

TEST_F(ReplayExamplesTest, SpeechIsEnhancedTowardsTheNearMicrophone) {
  write_near_sounds(folder_, {"SC-1022/0", "SC-1023/4", "SC-1026/2"});
  PairOptions enhance = options(Alignment::responses);
  enhance.target = PairTarget::near_microphone;
  const ReplayExamples examples(enhance, pose_of);
  const ReplayDataset dataset(replay_options(folder_, "train"));
  for (std::uint64_t number = 0; number < 4; ++number) {
    const TrainingExample example = examples.training(number);
    const std::size_t samples = example.target.size() / 2;
    ASSERT_EQ(samples, example.source.size() / 2);
    EXPECT_TRUE(std::equal(example.target.begin(), example.target.begin() + samples,
                           example.target.begin() + samples));
    // It is one of the views' near sound, not another view's sound.
    int matches = 0;
    for (const ReplayClip& clip : dataset.clips()) {
      for (int view = 0; view < 2; ++view) {
        const PairSample sample = ReplaySampler(dataset, 0).enhancement_sample(clip, view);
        EXPECT_EQ(norm(sample.source_from_target.position_m), 0.0);
        if (std::ranges::equal(sample.target.planar(), example.target)) ++matches;
      }
    }
    EXPECT_EQ(matches, 1) << number;
  }
  EXPECT_TRUE(examples.validation(0).has_value());
}

TEST_F(ReplayExamplesTest, FieldsOfViewAreReadWhereTheyAreKnown) {
  const fs::path known = folder_ / "data/appen_dataset/v3/clips.json";
  const std::string key = ReplayDataset(replay_options(folder_, "train")).clips()[0].folder;
  const auto fov_deg_of = [&](int view) {
    const ReplayDataset dataset(replay_options(folder_, "train"));
    const PairSample sample = replay_pair(dataset, dataset.clips()[0], {view, 1 - view}, false);
    return degrees_from_radians(sample.horizontal_fov_rad);
  };
  EXPECT_NEAR(fov_deg_of(0), 90.0, 1e-9);
  write_file(known, std::string_view(R"({")" + key + R"(": {"fov_deg": [70, null]}})"));
  EXPECT_NEAR(fov_deg_of(0), 70.0, 1e-9);
  EXPECT_NEAR(fov_deg_of(1), 90.0, 1e-9);
  for (const char* wrong : {"[70]", "[70, 180]", "[70, \"80\"]"}) {
    write_file(known, std::string_view(R"({")" + key + R"(": {"fov_deg": )" + wrong + "}}"));
    EXPECT_THROW(static_cast<void>(fov_deg_of(0)), InputError) << wrong;
  }
}

TEST_F(ReplayExamplesTest, FilesAreReadOnceWhereThereIsRoom) {
  write_near_sounds(folder_, {"SC-1022/0"});
  const ReplayDataset dataset(replay_options(folder_, "train"));
  const ReplayClip& clip = dataset.clips()[0];
  const ReplaySampler sampler(dataset, 10'000'000);
  const ReplaySampler forgetful(dataset, 0);
  const PairSample there = sampler.sample(clip, {0, 1}, true);
  const Waveform voice = sampler.near_voice(clip, there.source);
  fs::remove_all(folder_ / "data/appen_dataset/v3" / "SC-1022");
  const PairSample back = sampler.sample(clip, {0, 1}, true);
  EXPECT_TRUE(std::ranges::equal(back.source.planar(), there.source.planar()));
  EXPECT_TRUE(std::ranges::equal(back.target.planar(), there.target.planar()));
  EXPECT_EQ(back.picture, there.picture);
  EXPECT_TRUE(std::ranges::equal(sampler.near_voice(clip, back.source).planar(), voice.planar()));
  EXPECT_THROW(static_cast<void>(forgetful.sample(clip, {0, 1}, true)), InputError);
}

TEST_F(ReplayExamplesTest, NetworksOfRecordingsStartByTheirConfigurations) {
  write_near_sounds(folder_, {"SC-1022/0", "SC-1023/4", "SC-1026/2"});
  for (const std::string name : {"gtf", "vam", "vigas-small", "vigas-blind"}) {
    const bool is_blind = name == "vigas-blind";
    const std::vector<ConfigSetting> blind{{"network.picture", "null"}, {"network.box", "false"}};
    const TrainConfig config =
        read_train_config(fs::path(EARPOINT_SOURCE_DIR) / "configs" /
                              ((is_blind ? "vigas-small" : name) + "-replay.json"),
                          is_blind ? blind : std::vector<ConfigSetting>());
    TaskOptions task_options;
    task_options.data = folder_;
    task_options.layout = DatasetLayout::replay;
    const TrainingTask task = make_training_task(config, name, task_options);
    const std::vector<TrainingExample> examples{task.examples->training(0)};
    const TrainingBatch batch = join(examples);
    const double before = task.learner->compute_gradients(batch);
    EXPECT_TRUE(std::isfinite(before)) << name;
    task.learner->apply_gradients(1e-3);
    EXPECT_NE(task.learner->compute_gradients(batch), before) << name;
    EXPECT_TRUE(task.examples->validation(0).has_value()) << name;
  }
}

TEST_F(ReplayExamplesTest, ShippedNetworksCanBeTrainedOnRecordings) {
  write_near_sounds(folder_, {"SC-1022/0", "SC-1023/4", "SC-1026/2"});
  const fs::path source = EARPOINT_SOURCE_DIR;
  for (const std::string name : {"gtf", "enhance", "vigas"}) {
    std::vector<ConfigSetting> settings{
        {"network.init", '"' + (source / "models" / (name + ".safetensors")).string() + '"'}};
    const std::string config_name = (name == "vigas" ? "vigas-small" : name) + "-replay.json";
    const TrainConfig config = read_train_config(source / "configs" / config_name, settings);
    TaskOptions task_options;
    task_options.data = folder_;
    task_options.layout = DatasetLayout::replay;
    const TrainingTask task = make_training_task(config, name, task_options);
    const TrainingBatch batch = join(std::vector{task.examples->training(0)});
    EXPECT_TRUE(std::isfinite(task.learner->compute_gradients(batch))) << name;
  }
}

TEST_F(ReplayExamplesTest, GtfLearnsRecordingsWithoutTheSpeakersPlace) {
  write_near_sounds(folder_, {"SC-1022/0", "SC-1023/4", "SC-1026/2"});
  const TrainConfig config = train_config_from_json(
      R"({"format": "earpoint-train-1", "network": {"kind": "gtf", "channels": 16, "layers": 2,
          "bands": 12, "picture_px": 0, "dry_voice": true, "loss": {"dry_voice": 0.05}},
          "data": {"align": "gcc_phat"}, "training": {"steps": 1, "batch": 2}})",
      "c.json");
  TaskOptions task_options;
  task_options.data = folder_;
  task_options.layout = DatasetLayout::replay;
  const TrainingTask task = make_training_task(config, "c.json", task_options);
  const std::vector<TrainingExample> examples{task.examples->training(0),
                                              task.examples->training(1)};
  const TrainingBatch batch = join(examples);
  const double before = task.learner->compute_gradients(batch);
  for (int step = 0; step < 20; ++step) {
    task.learner->apply_gradients(1e-3);
    static_cast<void>(task.learner->compute_gradients(batch));
  }
  EXPECT_LT(task.learner->compute_gradients(batch), before);
}

TEST_F(ReplayExamplesTest, GtfNamesTheClipThatHasNoNearMicrophone) {
  const TrainConfig config =
      read_train_config(fs::path(EARPOINT_SOURCE_DIR) / "configs" / "gtf-replay.json");
  TaskOptions task_options;
  task_options.data = folder_;
  task_options.layout = DatasetLayout::replay;
  const TrainingTask task = make_training_task(config, "c.json", task_options);
  try {
    static_cast<void>(task.examples->training(0));
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("has no near.wav"), std::string::npos);
  }
}

TEST_F(ReplayExamplesTest, NetworksOfThePublishedSizeAreCheckpointsOfTheReleasedCode) {
  // From downloads without pair lists, each with its own pose encoding.
  for (const char* name : {"vigas-soundspaces", "vigas-replay"}) {
    const TrainConfig config = read_train_config(fs::path(EARPOINT_SOURCE_DIR) / "configs" /
                                                 (std::string(name) + ".json"));
    TaskOptions task_options;
    task_options.data = folder_;
    task_options.layout =
        name == std::string("vigas-replay") ? DatasetLayout::replay : DatasetLayout::soundspaces;
    const TrainingTask task = make_training_task(config, name, task_options);
    ASSERT_GT(task.examples->validations(), 0U);
    const TrainingExample example = task.examples->training(0);
    const bool replay = task_options.layout == DatasetLayout::replay;
    EXPECT_EQ(example.inputs.at("tgt_rotation").size(), replay ? 6U : 2U);
    EXPECT_EQ(example.picture.size(), replay ? 3U * 384 * 216 : 3U * 256 * 256);
    const ReleasedCheckpoint released = released_checkpoint(task.learner->weight_file(), name);
    EXPECT_EQ(released.state_dict.size(), 613U);
    EXPECT_EQ(released.hparams.size(), 146U);
    EXPECT_TRUE(released.differences.empty());
  }
}

TEST_F(ReplayExamplesTest, NetworksLearnInTheEncodingsOfBothDataSets) {
  for (const std::string encoding : {"soundspaces", "replay"}) {
    const bool replay = encoding == "replay";
    const TrainConfig config = train_config_from_json(
        R"({"format": "earpoint-train-1", "network": {"kind": "vigas", "pose_encoding": ")" +
            encoding + R"(", "blocks": 1, "layers_per_block": 2, "channels": 8, "init": "released",
            "picture": {"width_px": 32, "height_px": 32, "trunk_channels": 4}},
            "data": {"align": ")" +
            (replay ? "gcc_phat" : "responses") + R"("}, "training": {"steps": 1, "batch": 2}})",
        "c.json");
    TaskOptions task_options;
    task_options.data = folder_;
    task_options.layout = layout_named(encoding);
    const TrainingTask task = make_training_task(config, "c.json", task_options);
    const std::vector<TrainingExample> examples{task.examples->training(0),
                                                task.examples->training(1)};
    const TrainingBatch batch = join(examples);
    const double before = task.learner->compute_gradients(batch);
    for (int step = 0; step < 20; ++step) {
      task.learner->apply_gradients(1e-3);
      static_cast<void>(task.learner->compute_gradients(batch));
    }
    EXPECT_LT(task.learner->compute_gradients(batch), before) << encoding;
  }
}

}  // namespace
}  // namespace earpoint
