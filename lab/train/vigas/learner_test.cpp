#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/network_testing/refusal.h>
#include <earpoint/train/initial_weights.h>
#include <earpoint/train/vigas_learner.h>
#include <earpoint/vigas/description.h>
#include <earpoint/vigas/engine.h>
#include <earpoint/vigas/weights.h>

namespace earpoint {
namespace {

constexpr std::int64_t kSamples = 640;

ViGasDescription small() {
  ViGasDescription d;
  d.pose_encoding = PoseEncoding::full;
  d.box_encoding = BoxEncoding::corners;
  d.inputs = {{"tgt_pose", 3}, {"tgt_rotation", 6}, {"bboxes", 4}};
  d.fusion_width = 16;
  d.conditioning_width = 8;
  d.channels = 8;
  d.blocks = 2;
  d.layers_per_block = 3;
  return d;
}

std::vector<float> noise(std::int64_t count, double size, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> values(static_cast<std::size_t>(count));
  for (float& value : values) value = static_cast<float>(size * random.normal());
  return values;
}

TrainingBatch batch_for(const ViGasDescription& d, std::int64_t clips) {
  TrainingBatch batch;
  batch.clips = clips;
  batch.source = noise(clips * 2 * kSamples, 0.3, 1);
  batch.target = noise(clips * 2 * kSamples, 0.3, 2);
  if (d.image_encoder) {
    batch.pictures =
        noise(clips * 3 * d.image_encoder->height_px * d.image_encoder->width_px, 1, 3);
  }
  for (const ConditioningInput& input : d.inputs) {
    if (input.name == "visual_feat") continue;
    batch.inputs[input.name] = noise(clips * input.width, 1.0, 10 + input.name.size());
  }
  return batch;
}

/// Random weights, as initial ones leave the gates constant: every layer has an effect.
ViGasWeights stirred(const ViGasDescription& d) {
  ViGasWeights weights = initial_vigas_weights(d, 3);
  std::uint64_t seed = 100;
  for (auto& [name, tensor] : weights.tensors) {
    if (name.find(".conv.") == std::string::npos) continue;
    tensor = make_tensor<float>(noise(tensor.elements(), 0.2, seed++), tensor.shape);
  }
  return weights;
}

void expect_engines_prediction(const ViGasDescription& d) {
  const ViGasWeights weights = stirred(d);
  const TrainingBatch batch = batch_for(d, 1);
  ViGas engine(weights, 1);
  std::vector<float> feature;
  if (d.image_encoder) feature = engine.image_feature(batch.pictures);
  std::vector<ConditioningValues> inputs;
  for (const ConditioningInput& input : d.inputs) {
    inputs.push_back({input.name, input.name == "visual_feat" ? std::span<const float>(feature)
                                                              : batch.inputs.at(input.name)});
  }
  std::vector<float> fused(static_cast<std::size_t>(d.conditioning_width));
  engine.fuse(inputs, fused);
  std::vector<float> rendered(batch.source.size());
  engine.synthesize(batch.source, fused, rendered);

  const std::vector<float> prediction = ViGasLearner(weights).predict(batch);
  ASSERT_EQ(prediction.size(), rendered.size());
  for (std::size_t i = 0; i < rendered.size(); ++i) {
    // Two float32 implementations, values of order 1, of up to 24 layers.
    ASSERT_NEAR(prediction[i], rendered[i], 2e-5) << i;
  }
}

TEST(ViGasLearner, PredictsWhatTheEngineRenders) { expect_engines_prediction(small()); }

TEST(ViGasLearner, PredictsWhatTheEngineRendersFromAPicture) {
  ViGasDescription d = small();
  d.pose_encoding = PoseEncoding::soundspaces;
  d.image_encoder = ImageEncoderDescription{64, 32, 4, 16};
  d.inputs = {{"visual_feat", 8}, {"tgt_pose", 3}, {"tgt_rotation", 2}, {"bboxes", 4}};
  expect_engines_prediction(d);
}

TEST(ViGasLearner, PredictsWhatTheEngineRendersBlindly) {
  ViGasDescription d = small();
  d.inputs = {{"tgt_pose", 3}, {"tgt_rotation", 6}};
  expect_engines_prediction(d);
}

TEST(ViGasLearner, PredictsWhatTheEngineRendersFromThePastOnly) {
  ViGasDescription d = small();
  d.acausal = false;
  d.kernel_size = 2;
  d.dilation_base = 2;
  expect_engines_prediction(d);
}

TEST(ViGasLearner, PredictsWhatTheEngineRendersBeyondTheClipsEnds) {
  ViGasDescription d = small();
  d.layers_per_block = 7;  // 3^6 > 640: side taps read only zeros
  expect_engines_prediction(d);
}

// Central differences of the loss along a direction in which every parameter adds to the slope.
TEST(ViGasLearner, GradientIsTheSlopeOfTheLoss) {
  const ViGasDescription d = small();
  const ViGasWeights weights = stirred(d);
  const TrainingBatch batch = batch_for(d, 2);
  ViGasLearner learner(weights);
  learner.compute_gradients(batch);
  double slope = 0.0;
  ViGasWeights ahead = weights;
  ViGasWeights behind = weights;
  std::uint64_t seed = 1000;
  // Small against curvature (error ~ step^2), large against the loss's rounding (~ 1e-7 / step).
  constexpr double kStep = 1e-4;
  for (const auto& [name, gradient] : learner.gradients()) {
    std::vector<float> direction = noise(gradient.elements(), 1.0, seed++);
    for (std::size_t i = 0; i < direction.size(); ++i) {
      direction[i] = std::copysign(direction[i], gradient.as<float>()[i]);
    }
    const auto values = weights.at(name).as<float>();
    std::vector<float> plus(direction.size());
    std::vector<float> minus(direction.size());
    for (std::size_t i = 0; i < direction.size(); ++i) {
      slope += static_cast<double>(direction[i]) * gradient.as<float>()[i];
      plus[i] = values[i] + static_cast<float>(kStep) * direction[i];
      minus[i] = values[i] - static_cast<float>(kStep) * direction[i];
    }
    ahead.tensors[name] = make_tensor<float>(plus, gradient.shape);
    behind.tensors[name] = make_tensor<float>(minus, gradient.shape);
  }
  const double difference =
      ViGasLearner(ahead).compute_gradients(batch) - ViGasLearner(behind).compute_gradients(batch);
  // Curvature and the losses' rounding at this step.
  EXPECT_NEAR(difference / (2 * kStep), slope, 0.01 * std::abs(slope));
}

TEST(ViGasLearner, GoesOnFromItsCheckpointAsIfNeverStopped) {
  const ViGasDescription d = small();
  const TrainingBatch batch = batch_for(d, 2);
  ViGasLearner unbroken(initial_vigas_weights(d, 1));
  std::vector<double> losses;
  SafetensorsFile saved;
  for (int step = 0; step < 6; ++step) {
    if (step == 3) saved = unbroken.checkpoint();
    losses.push_back(unbroken.compute_gradients(batch));
    unbroken.apply_gradients(0.01);
  }
  ViGasLearner resumed = ViGasLearner::from_checkpoint(saved, "checkpoint");
  EXPECT_EQ(resumed.steps(), 3);
  for (std::size_t step = 3; step < 6; ++step) {
    EXPECT_EQ(resumed.compute_gradients(batch), losses[step]);
    resumed.apply_gradients(0.01);
  }
  EXPECT_TRUE(resumed.weights().tensors == unbroken.weights().tensors);
}

/// Resuming also works with the probe of the conditioning vector.
TEST(ViGasLearner, GoesOnWithItsProbe) {
  const ViGasDescription d = small();
  TrainingBatch batch = batch_for(d, 2);
  batch.inputs["place"] = noise(2 * 4, 1.0, 30);
  const LearnerOptions asked{.place = 0.5, .place_steps = 2};
  ViGasLearner unbroken(initial_vigas_weights(d, 1), asked);
  for (int step = 0; step < 3; ++step) {
    unbroken.compute_gradients(batch);
    unbroken.apply_gradients(0.01);
  }
  EXPECT_EQ(unbroken.steps(), 3);
  const SafetensorsFile saved = unbroken.checkpoint();
  ViGasLearner resumed = ViGasLearner::from_checkpoint(saved, "checkpoint", asked);
  for (int step = 0; step < 2; ++step) {
    EXPECT_EQ(resumed.compute_gradients(batch), unbroken.compute_gradients(batch));
    resumed.apply_gradients(0.01);
    unbroken.apply_gradients(0.01);
  }
  EXPECT_TRUE(resumed.weights().tensors == unbroken.weights().tensors);
  EXPECT_EQ(unbroken.weight_file().tensors.count("conditioning_probe.weight"), 0);
  SafetensorsFile without = saved;
  without.tensors.erase("conditioning_probe.weight");
  EXPECT_THROW(static_cast<void>(ViGasLearner::from_checkpoint(without, "checkpoint", asked)),
               InputError);
}

/// The sounds do not depend on the place, so only the probe's loss can teach it.
TEST(ViGasLearner, LearnsWhatItsProbeAsks) {
  const ViGasDescription d = small();
  constexpr int kClips = 8;
  TrainingBatch batch = batch_for(d, kClips);
  batch.target = batch.source;
  std::vector<float>& place = batch.inputs["place"];
  for (std::size_t clip = 0; clip < kClips; ++clip) {
    const float* box = &batch.inputs.at("bboxes")[4 * clip];
    place.insert(place.end(), {box[0], box[1] * box[0], box[2], box[3]});
  }
  ViGasLearner learner(initial_vigas_weights(d, 1), {.place = 100.0});
  const double first = learner.compute_gradients(batch);
  double last = first;
  for (int step = 0; step < 300; ++step) {
    learner.apply_gradients(0.01);
    last = learner.compute_gradients(batch);
  }
  // The probe's part is nearly all of the loss.
  EXPECT_LT(last, 0.1 * first);
}

TEST(ViGasLearner, AsksForThePlaceAndForNepersOfLevel) {
  const ViGasDescription d = small();
  TrainingBatch batch = batch_for(d, 1);
  batch.inputs["place"] = {0.6F, 0.8F, 0.5F, -0.5F};
  // The left ear e times as loud, the right ear as it was.
  batch.target = batch.source;
  for (std::int64_t i = 0; i < kSamples; ++i) batch.target[i] *= std::exp(1.0F);
  // A probe of zeros answers zero: the loss of a silent step is the sum of the squares. The floor
  // of levels at -60 dB takes a little of the left ear's.
  ViGasLearner learner(initial_vigas_weights(d, 1), {.place = 2.0, .place_steps = 1});
  EXPECT_NEAR(learner.compute_gradients(batch), 2.0 * (0.36 + 0.64 + 0.25 + 0.25 + 1.0), 1e-3);
}

TEST(ViGasLearner, FirstStepWithSoundIsAsLongAsTheFirstStepOfAll) {
  const ViGasDescription d = small();
  TrainingBatch batch = batch_for(d, 1);
  batch.inputs["place"] = noise(4, 1.0, 30);
  ViGasLearner learner(stirred(d), {.place = 1.0, .place_steps = 50});
  const auto stack = [&] { return learner.weights().at("input.weight"); };
  const Tensor before = stack();
  const auto step = [&] {
    learner.compute_gradients(batch);
    learner.apply_gradients(0.01);
  };
  for (int i = 0; i < 50; ++i) step();
  EXPECT_TRUE(stack() == before);  // no sound, no gradient
  step();
  const Tensor after = stack();
  // Adam's first step is the learning rate for any gradient that is large against its epsilon.
  for (std::int64_t i = 0; i < before.elements(); ++i) {
    EXPECT_NEAR(std::abs(after.as<float>()[i] - before.as<float>()[i]), 0.01, 1e-4);
  }
}

TEST(ViGasLearner, RefusesFilesThatAreNoCheckpoint) {
  ViGasLearner learner(initial_vigas_weights(small(), 1));
  const auto refusal_of = [&](const std::function<void(SafetensorsFile&)>& spoil) {
    SafetensorsFile file = learner.checkpoint();
    spoil(file);
    return refusal([&] { static_cast<void>(ViGasLearner::from_checkpoint(file, "x")); });
  };
  EXPECT_EQ(refusal_of([](SafetensorsFile&) {}), "accepted");
  EXPECT_NE(refusal_of([](SafetensorsFile& f) {
              f.tensors.erase("adam.second/input.bias");
            }).find("adam.second/input.bias"),
            std::string::npos);
  EXPECT_NE(refusal_of([](SafetensorsFile& f) {
              f.metadata["earpoint.adam_steps"] = "-2";
            }).find("earpoint.adam_steps"),
            std::string::npos);
}

TEST(ViGasLearner, RefusesADeviceThatIsNotThere) {
  LearnerOptions options;
  options.device = "quantum";
  EXPECT_NE(refusal([&] {
              ViGasLearner(initial_vigas_weights(small(), 1), options);
            }).find("device quantum"),
            std::string::npos);
}

TEST(ViGasLearner, LearnsOneClipByHeart) {
  ViGasDescription d = small();
  d.blocks = 1;
  d.layers_per_block = 4;
  d.channels = 16;
  TrainingBatch clip = batch_for(d, 1);
  // Each ear gets the other ear's sound, softer and later.
  for (std::int64_t i = 0; i < kSamples; ++i) {
    const std::int64_t earlier = std::max<std::int64_t>(0, i - 7);
    clip.target[i] = 0.5F * clip.source[kSamples + earlier];
    clip.target[kSamples + i] = 0.8F * clip.source[earlier];
  }
  ViGasLearner learner(initial_vigas_weights(d, 1));
  const double first = learner.compute_gradients(clip);
  double last = first;
  for (const double learning_rate : {0.01, 0.002, 0.0004}) {
    for (int step = 0; step < 500; ++step) {
      learner.apply_gradients(learning_rate);
      last = learner.compute_gradients(clip);
    }
  }
  // The rest is noise of the optimizer: 28 dB below the first error of magnitudes.
  EXPECT_LT(last, 0.04 * first);
}

}  // namespace
}  // namespace earpoint
