#include <algorithm>
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/core/random.h>
#include <earpoint/dataset/replay.h>
#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/evaluation.h>
#include <earpoint/evaluate/evaluation_set.h>
#include <earpoint/media/movie_writer.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/network_testing/random_weights.h>
#include <earpoint/plot/draw.h>
#include <earpoint/vigas/engine.h>
#include <earpoint/vigas/weights.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class ReplayEvaluationSetTest : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) / ("replay_set." + std::to_string(::getpid()));
    fs::remove_all(root_);
    write_tiny_replay_dataset(root_, {"SC-1027/3", "SC-1044/5"});
  }
  void TearDown() override { fs::remove_all(root_); }

  fs::path root_;
};

TEST_F(ReplayEvaluationSetTest, PairsHaveOurFrame) {
  const auto set = replay_evaluation_set(root_, "test", {});
  ASSERT_EQ(set->size(), 2U);
  EXPECT_NE(set->cluster(0), set->cluster(1));
  EXPECT_EQ(set->scene(0), "SC-1027");
  for (std::size_t pair = 0; pair < 2; ++pair) {
    const PairSample sample = set->sample(pair);
    const Vector3 target_m = sample.source_from_target.position_m;
    const double yaw_rad = euler_from_quaternion(sample.source_from_target.orientation).yaw_rad;
    const bool from_first = set->name(pair).find("1.png -> 2.png") != std::string::npos;
    // From camera 2, which looks to the left, camera 1 is 2 m behind and 1 m to the left.
    EXPECT_NEAR(target_m.x, from_first ? 1.0 : -2.0, 1e-9);
    EXPECT_NEAR(target_m.y, from_first ? 2.0 : 1.0, 1e-9);
    EXPECT_NEAR(yaw_rad, from_first ? kPi / 2 : -kPi / 2, 1e-9);
    EXPECT_EQ(sample.speaker_box, (Box{0.125, 0.25, 0.5, 0.75}));
    EXPECT_EQ(sample.picture->at(10, 10, 0), 200);
    EXPECT_FALSE(set->truth(pair).has_value());
  }
}

TEST_F(ReplayEvaluationSetTest, NetworksAreToldThePoseThatTheReleasedLoaderTellsThem) {
  ViGasDescription description;
  description.pose_encoding = PoseEncoding::replay;
  description.box_encoding = BoxEncoding::corners;
  description.inputs = {{"tgt_pose", 3}, {"tgt_rotation", 6}, {"bboxes", 4}};
  description.fusion_width = 8;
  description.conditioning_width = 8;
  description.channels = 8;
  description.blocks = 1;
  description.layers_per_block = 2;
  RandomStream random(4);
  ViGasWeights weights{.description = description, .tensors = {}, .unused = {}};
  weights.tensors = random_tensors(required_tensors(description), random, -0.3, 0.3);
  const fs::path file = root_ / "replay.safetensors";
  write_safetensors(file, to_weight_file(weights));

  ReplayDataset::Options options;
  options.root = root_;
  const ReplayDataset dataset(options);
  const auto set = replay_evaluation_set(root_, "test", {});
  NumpyRandom draws(0);
  bool looks_elsewhere = false;
  for (std::size_t pair = 0; pair < set->size(); ++pair) {
    const ReplayClip& clip = dataset.clips()[pair];
    const ReplayChoice choice = dataset.draw(clip, draws);
    looks_elsewhere = looks_elsewhere || clip.images[choice.source] == "2.png";
    const NvasSample loaded = dataset.sample(clip, choice, false);
    const auto floats = [](const std::vector<double>& values) {
      return std::vector<float>(values.begin(), values.end());
    };
    const auto pose = floats(loaded.tgt_pose);
    const auto rotation = floats(loaded.tgt_rotation);
    const auto box = floats(loaded.bboxes);
    ViGas network(weights, 1);
    std::vector<float> fused(8);
    const std::vector<ConditioningValues> inputs{
        {"tgt_pose", pose}, {"tgt_rotation", rotation}, {"bboxes", box}};
    network.fuse(inputs, fused);
    std::vector<float> expected(loaded.source.planar().size());
    network.synthesize(loaded.source.planar(), fused, expected);

    const PairSample sample = set->sample(pair);
    const Waveform answer =
        network_method("replay", file.string()).make()->render({sample, set->scene(pair)});
    ASSERT_EQ(answer.planar().size(), expected.size());
    float greatest = 0.0F;
    for (const float x : expected) greatest = std::max(greatest, std::abs(x));
    for (std::size_t i = 0; i < expected.size(); ++i) {
      // Centimetres are converted to metres and back: float rounding.
      ASSERT_NEAR(answer.planar()[i], expected[i], 1e-4 * greatest) << pair << ", " << i;
    }
  }
  EXPECT_TRUE(looks_elsewhere) << "no source of the test looks along another axis than x";
}

TEST_F(ReplayEvaluationSetTest, OnlyTheReleasedColumnIsAlignedByTheTarget) {
  const auto set = replay_evaluation_set(root_, "test", {});
  SilentProgress silent;
  const std::vector<MethodEntry> methods{input_method()};
  const EvaluationResult result = evaluate(*set, methods, {}, silent);
  ASSERT_FALSE(result.clips.empty());
  for (const ClipResult& clip : result.clips) {
    EXPECT_EQ(clip.honest[0][Metric::delay], 20.0);
    EXPECT_EQ(clip.released[0][Metric::delay], 0.0);
    EXPECT_LT(clip.released[0][Metric::mag].value(), 0.1 * clip.honest[0][Metric::mag].value());
    EXPECT_FALSE(clip.speaker_m.has_value());
  }
}

TEST_F(ReplayEvaluationSetTest, MethodsThatMustKnowTheSpeakerAreRefused) {
  const auto set = replay_evaluation_set(root_, "test", 1);
  SilentProgress silent;
  const std::vector<MethodEntry> methods{dsp_method()};
  EXPECT_THROW((void)evaluate(*set, methods, {}, silent), InputError);
}

TEST_F(ReplayEvaluationSetTest, AMissingPictureIsTheMoviesFirstFrame) {
  const auto set = replay_evaluation_set(root_, "test", {});
  for (const char* camera : {"1", "2"}) {
    const fs::path stem = root_ / "data/appen_dataset/v3/SC-1027/3" / camera;
    fs::remove(stem.string() + ".png");
  }
  EXPECT_THROW((void)set->sample(0), InputError);
  for (const char* camera : {"1", "2"}) {
    const fs::path stem = root_ / "data/appen_dataset/v3/SC-1027/3" / camera;
    MovieWriter movie(stem.string() + ".mp4", 64, 36, 10.0, 16000);
    movie.write_sound(Waveform(2, 3200, 16000));
    movie.write_picture(filled_image(64, 36, {200, 10, 30}));
    movie.write_picture(filled_image(64, 36, {10, 200, 30}));
    movie.close();
  }
  // Colours of a movie are rounded and its picture is coded with loss.
  EXPECT_NEAR(set->sample(0).picture->at(100, 100, 0), 200, 8);
}

}  // namespace
}  // namespace earpoint
