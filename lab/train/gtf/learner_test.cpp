#include "test_batches.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/energy.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/train/gtf_learner.h>
#include <earpoint/train/initial_weights.h>
#include <earpoint/train/vigas_learner.h>

namespace earpoint {
namespace {

using namespace gtf_test;

TEST(InitialGtfWeights, TablesHearTheNearEarEarlierAndLouder) {
  const GtfWeights weights = initial_gtf_weights(GtfDescription{}, head(), 1);
  const auto power = weights.at("head.power").as<float>();
  const auto delay_s = weights.at("head.delay_s").as<float>();
  constexpr int kLeft = GtfDescription::kHeadAzimuths / 4;
  // Woodworth's sphere of 8.75 cm: 0.66 ms at the side. KEMAR's onsets are up to 45 us off it
  // (hrtf_test).
  EXPECT_NEAR(delay_s[2 * kLeft + 1] - delay_s[2 * kLeft], 0.66e-3, 0.15e-3);
  EXPECT_NEAR(delay_s[1] - delay_s[0], 0.0, 0.05e-3);
  // At 3 to 5 kHz the head casts a shadow of well over 6 dB.
  constexpr int kBand = 6;
  EXPECT_GT(power[(2 * kLeft) * 8 + kBand], 4 * power[(2 * kLeft + 1) * 8 + kBand]);
  // The default set is diffuse-field equalised: below the highest bands an ear has the level of a
  // microphone, up to the smoothing of the equalisation.
  const auto diffuse = weights.at("head.diffuse_power").as<float>();
  for (int band = 1; band < 7; ++band) EXPECT_NEAR(diffuse[band], 1.0F, 0.3F) << band;
}

TEST(GtfLearner, StartsAsACopyOfTheMagnitudes) {
  const GtfDescription d = small();
  GtfLearner learner(initial_gtf_weights(d, head(), 1));
  TrainingBatch batch = batch_for(d, 1);
  batch.target = batch.source;
  const double copied = learner.errors(batch)[0];
  batch.target.assign(batch.target.size(), 0.0F);
  // The difference comes from small random kernels and phases that are half the speaker's.
  EXPECT_LT(copied, 0.5 * learner.errors(batch)[0]);
}

TEST(GtfLearner, LouderInGivesLouderOut) {
  const GtfDescription d = small();
  GtfLearner learner(stirred(d));
  TrainingBatch batch = batch_for(d, 2);
  const std::vector<float> first = learner.predict(batch);
  for (float& sample : batch.source) sample *= 4.0F;  // a power of two: no rounding
  const std::vector<float> louder = learner.predict(batch);
  for (std::size_t i = 0; i < first.size(); ++i) {
    ASSERT_NEAR(louder[i], 4.0F * first[i], 1e-6) << i;
  }
}

// Left in the table is left at the output, before any training.
TEST(GtfLearner, MovesTheSpeakerToTheSideThatGeometryTells) {
  GtfDescription d = small();
  GtfWeights weights = initial_gtf_weights(d, head(), 1);
  // The phase is all the speaker's.
  weights.tensors["phase.bias"] = make_tensor<float>(
      std::vector<float>(static_cast<std::size_t>(2 * d.bands), 20.0F), {2 * d.bands});
  GtfLearner learner(weights);
  TrainingBatch batch = batch_for(d, 1);
  std::copy_n(batch.source.begin(), kSamples, batch.source.begin() + kSamples);
  const std::vector<float> place = learner.locate(batch);
  const double bearing_rad = std::atan2(place[1], place[0]);
  batch.inputs["target_m"] = {0, 0, 0};
  const auto later_at_right = [&](double azimuth_rad) {
    // The listener turns so that the speaker is at that azimuth.
    batch.inputs["target_yaw_rad"] = {static_cast<float>(bearing_rad - azimuth_rad)};
    const std::vector<float> heard = learner.predict(batch);
    // The lag of the right ear with the highest correlation.
    int best = 0;
    double most = -1e9;
    for (int lag = -20; lag <= 20; ++lag) {
      double sum = 0.0;
      for (int i = 100; i < kSamples - 100; ++i) {
        sum += double{heard[i]} * heard[kSamples + i + lag];
      }
      if (sum > most) {
        most = sum;
        best = lag;
      }
    }
    return best;
  };
  EXPECT_GT(later_at_right(0.5 * kPi), 5);
  EXPECT_LT(later_at_right(-0.5 * kPi), -5);
  EXPECT_NEAR(later_at_right(0.0), 0, 1);  // whole samples
}

/// Central differences of the loss along a direction in which every parameter adds to the slope.
/// @param tolerance  relative
void expect_slope(const GtfDescription& d, std::int64_t clips = 2, double tolerance = 0.02) {
  const GtfWeights weights = stirred(d);
  const TrainingBatch batch = batch_for(d, clips);
  GtfLearnerOptions options;
  options.loss = {.log_magnitude = 0.1,
                  .level_difference = 0.01,
                  .level = 0.01,
                  .modulation = 0.03,
                  .decay = 0.01,
                  .phase_difference = 0.1,
                  .dry_voice = d.dry_voice ? 0.1 : 0.0,
                  .place = 0.1};
  if (d.texture) {
    options.natural_loss = options.loss;
    options.natural_loss->modulation = 0.1;
  }
  GtfLearner learner(weights, options);
  learner.compute_gradients(batch);
  double slope = 0.0;
  GtfWeights ahead = weights;
  GtfWeights behind = weights;
  std::uint64_t seed = 1000;
  // Small against curvature (error ~ step^2), large against the loss's rounding (~ 1e-7 / step).
  constexpr double kStep = 1e-5;
  for (const auto& [name, gradient] : learner.gradients()) {
    std::vector<float> plus = noise(gradient.elements(), 1.0, seed++);
    std::vector<float> minus(plus.size());
    const auto values = weights.at(name).as<float>();
    double share = 0.0;
    for (std::size_t i = 0; i < plus.size(); ++i) {
      const float step = std::copysign(plus[i], gradient.as<float>()[i]);
      share += double{step} * gradient.as<float>()[i];
      plus[i] = values[i] + static_cast<float>(kStep) * step;
      minus[i] = values[i] - static_cast<float>(kStep) * step;
    }
    EXPECT_GT(share, 0.0) << name << " has no gradient";
    slope += share;
    ahead.tensors[name] = make_tensor<float>(plus, gradient.shape);
    behind.tensors[name] = make_tensor<float>(minus, gradient.shape);
  }
  const double difference = GtfLearner(ahead, options).compute_gradients(batch) -
                            GtfLearner(behind, options).compute_gradients(batch);
  // Curvature and the losses' rounding at this step.
  EXPECT_NEAR(difference / (2 * kStep), slope, tolerance * std::abs(slope));
}

TEST(GtfLearner, GradientIsTheSlopeOfTheLoss) { expect_slope(small()); }

TEST(GtfLearner, GradientIsTheSlopeOfTheLossOfABatchInParts) { expect_slope(small(), 6); }

TEST(GtfLearner, GradientIsTheSlopeOfTheLossWithPhaseRoundsTexturesAndADryVoice) {
  GtfDescription d = small();
  d.phase_rounds = 2;
  d.ear_delays = d.texture = d.dry_voice = true;
  // Two parts, one of each texture. In bins of almost no energy the phase turns far within a step;
  // gtf_passes_test checks the gradient of phase rounds to 0.2 %.
  expect_slope(d, 6, 0.05);
}

TEST(GtfLearner, GradientIsTheSlopeOfTheLossWithExpectedLevels) {
  GtfDescription d = small();
  d.expected_level = true;
  expect_slope(d);
}

TEST(GtfLearner, GradientIsTheSlopeOfTheLossWithSightPoints) {
  GtfDescription d = small();
  d.sight_points = 2;
  expect_slope(d, 6);
}

/// @param parts  what `before` gets and has not
void expect_as_before(const GtfWeights& before, const GtfDescription& parts) {
  const GtfWeights after = with_new_parts(before, parts, 1);
  EXPECT_EQ(after.description, parts);
  const TrainingBatch batch = batch_for(parts, 2);
  const std::vector<float> expected = GtfLearner(before).predict(batch);
  GtfLearnerOptions options;
  if (parts.texture) options.natural_loss = options.loss;
  const std::vector<float> found = GtfLearner(after, options).predict(batch);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    // Only zeros are added, but the order of float32 sums may change.
    ASSERT_NEAR(found[i], expected[i], 1e-5) << i;
  }
}

TEST(GtfLearner, RendersAsBeforeWithPartsThatAreNew) {
  const GtfDescription d = small();
  GtfDescription parts = d;
  parts.sight_points = 3;
  expect_as_before(stirred(d), parts);
  parts.texture = parts.dry_voice = true;
  expect_as_before(stirred(d), parts);
}

TEST(GtfLearner, KeepsItsSightWhenATextureIsAdded) {
  GtfDescription d = small();
  d.sight_points = 2;
  GtfDescription parts = d;
  parts.texture = true;
  expect_as_before(stirred(d), parts);
}

TEST(GtfLearner, GetsEarDelaysExpectedLevelsAndPhaseRoundsWithTheSameTensors) {
  const GtfDescription d = small();
  GtfDescription parts = d;
  parts.ear_delays = parts.expected_level = true;
  parts.phase_rounds = 2;
  const GtfWeights before = stirred(d);
  const GtfWeights after = with_new_parts(before, parts, 1);
  EXPECT_EQ(after.description, parts);
  ASSERT_EQ(after.tensors.size(), before.tensors.size());
  for (const auto& [name, tensor] : before.tensors) {
    EXPECT_TRUE(std::ranges::equal(after.tensors.at(name).as<float>(), tensor.as<float>())) << name;
  }
}

TEST(GtfLearner, TheWayToTheTargetCountsWhereThePictureShowsIt) {
  GtfDescription d = small();
  d.sight_points = 2;
  GtfWeights weights = stirred(d);
  // The picture has an effect only through its sight points.
  for (const char* name : {"picture.output.weight", "picture.output.bias"}) {
    Tensor& tensor = weights.tensors.at(name);
    tensor = make_tensor<float>(
        std::vector<float>(static_cast<std::size_t>(tensor.elements()), 0.0F), tensor.shape);
  }
  GtfLearner learner(weights);
  TrainingBatch open = batch_for(d, 1);
  TrainingBatch wall = open;
  wall.pictures = noise(std::int64_t{3} * d.picture_px * d.picture_px, 0.2, 90);
  const auto predicted = [&](TrainingBatch clip, float front_m) {
    clip.inputs["target_m"] = {front_m, 0.2F, 0};
    return learner.predict(clip);
  };
  EXPECT_NE(predicted(open, 3), predicted(wall, 3));
  EXPECT_EQ(predicted(open, -3), predicted(wall, -3));
}

TEST(GtfLearner, LearnsATextureForEachOfItsLosses) {
  GtfDescription d = small();
  d.texture = true;
  TrainingBatch clip = batch_for(d, 1);
  clip.target = clip.source;
  GtfLearnerOptions options;
  options.natural_loss = options.loss;
  // In this test the natural texture is 6 dB louder.
  GtfLearner learner(initial_gtf_weights(d, head(), 1), options);
  TrainingBatch louder = clip;
  for (float& sample : louder.target) sample *= 2.0F;
  for (int step = 0; step < 120; ++step) {
    // One clip is one part, whose texture alternates with the steps.
    learner.compute_gradients(step % 2 == 0 ? clip : louder);
    learner.apply_gradients(0.01);
  }
  const auto energy_of = [&](double texture) { return energy(learner.predict(clip, texture)); };
  // A factor of 4 in power once it is fully learned.
  EXPECT_GT(energy_of(1.0), 2.0 * energy_of(0.0));
}

/// Distance of the first clip's speaker from where the learner locates them, in metres.
double place_error_m(GtfLearner& learner, const TrainingBatch& batch) {
  const std::vector<float> found = learner.locate(batch);
  const std::vector<float>& wanted = batch.inputs.at("speaker_m");
  return std::hypot(found[0] - wanted[0], found[1] - wanted[1], found[2] - wanted[2]);
}

TEST(GtfLearner, LocatesTheSpeakerFirstWhereToldTo) {
  const GtfDescription d = small();
  const TrainingBatch batch = batch_for(d, 6);
  constexpr int kPlaceSteps = 60;
  GtfLearnerOptions options;
  options.place_steps = kPlaceSteps;
  GtfLearner learner(stirred(d), options);
  const double first_m = place_error_m(learner, batch);
  for (int step = 0; step < kPlaceSteps; ++step) {
    learner.compute_gradients(batch);
    for (const auto& [name, gradient] : learner.gradients()) {
      if (name.starts_with("picture.") || name.starts_with("locator.")) continue;
      const auto values = gradient.as<float>();
      ASSERT_TRUE(std::ranges::all_of(values, [](float value) { return value == 0.0F; })) << name;
    }
    learner.apply_gradients(0.01);
  }
  EXPECT_LT(place_error_m(learner, batch), 0.5 * first_m);
  learner.compute_gradients(batch);
  const auto gain = learner.gradients().at("gain.weight").as<float>();
  EXPECT_TRUE(std::ranges::any_of(gain, [](float value) { return value != 0.0F; }));
}

TEST(GtfLearner, LearnsPlacesAsWithTheWholeLoss) {
  const GtfDescription d = small();
  const TrainingBatch batch = batch_for(d, 5);
  const auto gradients = [&](double place, std::int64_t place_steps) {
    GtfLearnerOptions options;
    options.loss.place = place;
    options.place_steps = place_steps;
    GtfLearner learner(stirred(d), options);
    learner.compute_gradients(batch);
    return learner.gradients();
  };
  const auto alone = gradients(1.0, 1);
  const auto little = gradients(0.5, 0);
  const auto more = gradients(1.5, 0);
  for (const char* name : {"locator.0.weight", "locator.2.bias", "picture.0.weight"}) {
    const auto expected = alone.at(name).as<float>();
    for (std::size_t i = 0; i < expected.size(); ++i) {
      // Rounding of the rest of the loss.
      ASSERT_NEAR(more.at(name).as<float>()[i] - little.at(name).as<float>()[i], expected[i], 1e-5)
          << name;
    }
  }
}

TEST(GtfLearner, LearnsTheSameWithAnyNumberOfThreads) {
  const GtfDescription d = small();
  const TrainingBatch batch = batch_for(d, 10);
  const auto learned = [&](int threads) {
    set_learner_threads(threads);
    GtfLearner learner(stirred(d));
    learner.compute_gradients(batch);
    return learner.gradients();
  };
  const auto alone = learned(1);
  EXPECT_TRUE(learned(3) == alone);
  set_learner_threads(1);
}

TEST(GtfLearner, GradientIsTheSlopeOfTheLossWithoutGeometryPictureOrTails) {
  GtfDescription d = small();
  d.geometry = d.delays = d.box = false;
  d.picture_px = 0;
  d.tails_s.clear();
  expect_slope(d);
}

TEST(GtfLearner, GoesOnFromItsCheckpointAsIfNeverStopped) {
  const GtfDescription d = small();
  const TrainingBatch batch = batch_for(d, 2);
  GtfLearner unbroken(initial_gtf_weights(d, head(), 1));
  std::vector<double> losses;
  SafetensorsFile saved;
  for (int step = 0; step < 4; ++step) {
    if (step == 2) saved = unbroken.checkpoint();
    losses.push_back(unbroken.compute_gradients(batch));
    unbroken.apply_gradients(0.01);
  }
  GtfLearner resumed = GtfLearner::from_checkpoint(saved, "checkpoint");
  EXPECT_EQ(resumed.steps(), 2);
  for (std::size_t step = 2; step < 4; ++step) {
    EXPECT_EQ(resumed.compute_gradients(batch), losses[step]);
    resumed.apply_gradients(0.01);
  }
  EXPECT_TRUE(resumed.weights().tensors == unbroken.weights().tensors);
}

TEST(GtfLearner, LearnsOneClipByHeart) {
  const GtfDescription d = small();
  TrainingBatch clip = batch_for(d, 1);
  // The ears are exchanged and have gains of 0.5 and 0.8.
  for (std::int64_t i = 0; i < kSamples; ++i) {
    clip.target[i] = 0.5F * clip.source[kSamples + i];
    clip.target[kSamples + i] = 0.8F * clip.source[i];
  }
  GtfLearner learner(initial_gtf_weights(d, head(), 1));
  const double first = learner.errors(clip)[0];
  for (const double learning_rate : {0.01, 0.003}) {
    for (int step = 0; step < 100; ++step) {
      learner.compute_gradients(clip);
      learner.apply_gradients(learning_rate);
    }
  }
  // Magnitudes can be learned. Phases stay a mixture of both ears, so that frames interfere.
  EXPECT_LT(learner.errors(clip)[0], 0.35 * first);
}

TEST(GtfExample, HoldsWhatTheNetworkIsToldAndWhereTheSpeakerIs) {
  PairSample sample;
  sample.source = Waveform(2, 16000, 16000);
  sample.target = Waveform(2, 16000, 16000);
  sample.picture = std::make_shared<const Image>(64, 64, 3, std::uint8_t{51});
  sample.speaker_box = Box{0.1, 0.2, 0.3, 0.4};
  sample.source_from_target = {{1, 2, 3}, quaternion_from_euler({.yaw_rad = 0.5})};
  sample.speaker_m = {2, 1, 0};
  sample.speaker_yaw_rad = 0.5 * kPi;
  GtfDescription d = small();
  TrainingExample example = gtf_example(d, sample);
  ASSERT_EQ(example.picture.size(), 3U * 32 * 32);
  EXPECT_NEAR(example.picture[5], 0.2F, 1e-6F);
  EXPECT_EQ(example.inputs.at("speaker_box"), (std::vector<float>{1, 0.1F, 0.2F, 0.3F, 0.4F}));
  EXPECT_EQ(example.inputs.at("target_m"), (std::vector<float>{1, 2, 3}));
  EXPECT_NEAR(example.inputs.at("target_yaw_rad")[0], 0.5F, 1e-6F);
  EXPECT_NEAR(example.inputs.at("speaker_heading")[1], 1.0F, 1e-6F);
  sample.speaker_box.reset();
  sample.speaker_yaw_rad.reset();
  d.picture_px = 0;
  example = gtf_example(d, sample);
  EXPECT_TRUE(example.picture.empty());
  EXPECT_EQ(example.inputs.at("speaker_box"), std::vector<float>(5));
  EXPECT_EQ(example.inputs.at("speaker_heading"), std::vector<float>(2));
}

}  // namespace
}  // namespace earpoint
