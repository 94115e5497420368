#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/engine.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/train/gtf_learner.h>

namespace earpoint {
namespace {

std::vector<float> noise(std::int64_t count, double size, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> values(static_cast<std::size_t>(count));
  for (float& value : values) value = static_cast<float>(size * random.normal());
  return values;
}

/// Initial weights with random kernels, gains and phases, so that all have an effect.
GtfWeights stirred(const GtfDescription& d) {
  GtfWeights weights = initial_gtf_weights(d, HrtfSet::load(GtfDescription::kSampleRateHz), 3);
  std::uint64_t seed = 100;
  for (auto& [name, tensor] : weights.tensors) {
    if (!name.starts_with("kernel") && !name.starts_with("gain") && !name.starts_with("phase")) {
      continue;
    }
    std::vector<float> values = noise(tensor.elements(), 0.02, seed++);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += tensor.as<float>()[i];
    tensor = make_tensor<float>(values, tensor.shape);
  }
  return weights;
}

void expect_engines_prediction(const GtfDescription& d, bool is_seen, std::int64_t samples,
                               double tolerance = 2e-5) {
  const GtfWeights weights = stirred(d);
  TrainingBatch batch;
  batch.clips = 1;
  batch.source = noise(2 * samples, 0.1, 1);
  if (d.picture_px > 0)
    batch.pictures = noise(std::int64_t{3} * d.picture_px * d.picture_px, 0.3, 2);
  const Box box{0.3, 0.4, 0.5, 0.9};
  batch.inputs["speaker_box"] =
      is_seen ? std::vector<float>{1, 0.3F, 0.4F, 0.5F, 0.9F} : std::vector<float>(5);
  batch.inputs["target_m"] = {1.5F, -0.7F, 0.2F};
  batch.inputs["target_yaw_rad"] = {0.8F};
  GtfLearnerOptions options;
  constexpr double kTexture = 0.3;
  if (d.texture) options.natural_loss = options.loss;
  const std::vector<float> expected = GtfLearner(weights, options).predict(batch, kTexture);

  Gtf engine(weights);
  engine.ask_for_texture(kTexture);
  engine.set_picture(batch.pictures, is_seen ? std::optional(box) : std::nullopt);
  engine.set_pose({{1.5, -0.7, 0.2}, quaternion_from_euler({.yaw_rad = 0.8})});
  std::vector<float> found(expected.size());
  engine.synthesize(batch.source, found);
  for (std::size_t i = 0; i < found.size(); ++i) {
    // Two float32 implementations, values of order 0.1 to 1; the requirement is 1e-4.
    ASSERT_NEAR(found[i], expected[i], tolerance) << i;
  }
}

TEST(GtfEngine, RendersWhatTheLearnerPredicts) {
  expect_engines_prediction(GtfDescription{}, true, 16000);
}

TEST(GtfEngine, RendersWhatTheLearnerPredictsOfAnUnseenSpeaker) {
  expect_engines_prediction(GtfDescription{}, false, 16000);
}

TEST(GtfEngine, RendersWhatTheLearnerPredictsAtAnyLength) {
  GtfDescription d;
  d.channels = 12;  // not whole chunks
  d.bands = 12;
  d.picture_px = 32;
  d.past_frames = 0;
  d.future_frames = 3;
  d.look_ahead_frames = 1;
  expect_engines_prediction(d, true, 5123);
}

TEST(GtfEngine, RendersWhatTheLearnerPredictsWithRoundsOfPhasesAndATexture) {
  GtfDescription d;
  d.channels = 12;
  d.bands = 12;
  d.picture_px = 32;
  d.phase_rounds = 2;
  d.texture = true;
  d.ear_delays = true;
  d.dry_voice = true;  // which rendering ignores
  // In bins of almost no energy rounding decides the phase, which phase rounds spread to
  // neighbours.
  expect_engines_prediction(d, true, 5123, 1e-4);
}

TEST(GtfEngine, RendersWhatTheLearnerPredictsFromExpectedLevels) {
  GtfDescription d;
  d.channels = 12;
  d.bands = 12;
  d.picture_px = 32;
  d.expected_level = true;
  expect_engines_prediction(d, true, 5123);
}

TEST(GtfEngine, UntrainedItChangesTheLevelAsGeometryExpects) {
  GtfDescription d;
  d.channels = 12;
  d.bands = 12;
  d.picture_px = 0;
  d.box = d.delays = false;
  d.expected_level = true;
  const auto gain_db = [&](float log_reverberant) {
    GtfWeights weights = initial_gtf_weights(d, HrtfSet::load(GtfDescription::kSampleRateHz), 3);
    Tensor& layer = weights.tensors.at("locator.2.weight");
    layer = make_tensor<float>(std::vector<float>(layer.elements(), 0.0F), layer.shape);
    Tensor& bias = weights.tensors.at("locator.2.bias");
    std::vector<float> outputs(bias.elements(), 0.0F);
    constexpr std::size_t kLogReverberant = 6;
    outputs[kLogReverberant] = log_reverberant;
    bias = make_tensor<float>(outputs, bias.shape);
    Gtf engine(weights);
    engine.set_picture({}, std::nullopt);
    engine.set_pose({{1, 0, 0}, {}}, Vector3{2, 0, 0});
    const std::vector<float> source = noise(2 * 8000, 0.1, 1);
    std::vector<float> found(source.size());
    engine.synthesize(source, found);
    const auto energy = [](const std::vector<float>& sound) {
      return std::inner_product(sound.begin(), sound.end(), sound.begin(), 0.0);
    };
    return 10 * std::log10(energy(found) / energy(source));
  };
  // Kernels start with random parts of 0.002. Half the distance: twice the direct sound, and the
  // same diffuse field.
  EXPECT_NEAR(gain_db(-20), 6.02, 0.1);
  EXPECT_NEAR(gain_db(20), 0.0, 0.1);
}

TEST(GtfEngine, RendersWhatTheLearnerPredictsWithSightPoints) {
  GtfDescription d;
  d.channels = 12;
  d.bands = 12;
  d.sight_points = 4;
  expect_engines_prediction(d, true, 5123);
}

TEST(GtfEngine, RendersWhatTheLearnerPredictsBlindly) {
  GtfDescription d;
  d.geometry = d.delays = d.box = false;
  d.picture_px = 0;
  d.tails_s.clear();
  d.future_frames = 0;
  expect_engines_prediction(d, true, 8000);
}

}  // namespace
}  // namespace earpoint
