#include "test_batches.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <gtest/gtest.h>

#include <earpoint/gtf/description.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/rt60/description.h>
#include <earpoint/rt60/engine.h>
#include <earpoint/train/gtf_learner.h>
#include <earpoint/train/initial_weights.h>

namespace earpoint {
namespace {

using namespace gtf_test;

/// The contribution of one loss to the sum, for an untrained network.
double added_loss(const GtfDescription& d, const GtfLearnerOptions& with,
                  const GtfLearnerOptions& without, const TrainingBatch& batch) {
  const GtfWeights weights = initial_gtf_weights(d, head(), 1);
  return GtfLearner(weights, with).compute_gradients(batch) -
         GtfLearner(weights, without).compute_gradients(batch);
}

TEST(GtfLearner, TheDryVoiceIsComparedWithWhatWasSpoken) {
  GtfDescription d = small();
  d.dry_voice = true;
  TrainingBatch batch = batch_for(d, 1);
  const auto dry_loss = [&](const TrainingBatch& clip) {
    GtfLearnerOptions with;
    with.loss.dry_voice = 1.0;
    return added_loss(d, with, {}, clip);
  };
  // The untrained network gives the mean magnitude of both ears as the voice.
  std::copy_n(batch.source.begin(), kSamples, batch.source.begin() + kSamples);
  batch.inputs["dry"].assign(batch.source.begin(), batch.source.begin() + kSamples);
  const double same = dry_loss(batch);
  batch.inputs["dry"] = noise(kSamples, 0.1, 70);
  EXPECT_LT(same, 0.1 * dry_loss(batch));
}

TEST(GtfLearner, ModulationCountsGapsThatAreFilled) {
  // The untrained network returns its input: noise in four bursts with silence between.
  const GtfDescription d = small();
  TrainingBatch bursts = batch_for(d, 1);
  for (std::int64_t i = 0; i < 2 * kSamples; ++i) {
    if (i / 500 % 2 == 1) bursts.source[i] = 0;
  }
  bursts.target = bursts.source;
  TrainingBatch filled = bursts;
  filled.target = batch_for(d, 1).source;
  const auto modulation = [&](const TrainingBatch& batch) {
    GtfLearnerOptions without;
    without.loss.modulation = 0.0;
    GtfLearnerOptions with = without;
    with.loss.modulation = 1.0;
    return added_loss(d, with, without, batch);
  };
  // Bursts are 40 dB above the floor for half of the time, a spread of 2 nepers; noise varies by
  // half a neper. The difference between copy and truth comes from mixed phases.
  EXPECT_GT(modulation(filled), 1.0);
  EXPECT_LT(modulation(bursts), 0.3 * modulation(filled));
}

TEST(GtfLearner, SquaredLevelsCountFarMistakesMost) {
  // The untrained network returns its input, except for mixed phases.
  const GtfDescription d = small();
  const GtfWeights weights = initial_gtf_weights(d, head(), 1);
  TrainingBatch batch = batch_for(d, 2);
  batch.target = GtfLearner(weights).predict(batch);
  // The first clip's target is right, the second's is 12 dB down: in the mean 6 dB, and half of
  // 144.
  const float down = std::pow(10.0F, -12.0F / 20.0F);
  for (std::int64_t i = 2 * kSamples; i < 4 * kSamples; ++i) batch.target[i] *= down;
  GtfLearnerOptions without;
  without.loss.level = 0.0;
  GtfLearnerOptions with = without;
  with.loss.level = 1.0;
  // A level is that of the sound's energy and 1e-3, which changes 12 dB by 0.01.
  EXPECT_NEAR(added_loss(d, with, without, batch), 6.0, 0.01);
  with.loss.level = 0.0;
  with.loss.squared_level = 1.0;
  EXPECT_NEAR(added_loss(d, with, without, batch), 72.0, 0.3);
}

TEST(GtfLearner, DecayCountsReverberationThatIsMissing) {
  // The untrained network returns its input, the dry speech itself.
  const GtfDescription d = small();
  TrainingBatch copy = batch_for(d, 1);
  copy.inputs["dry"].assign(copy.source.begin(), copy.source.begin() + kSamples);
  std::copy_n(copy.source.begin(), kSamples, copy.source.begin() + kSamples);
  copy.target = copy.source;
  TrainingBatch reverberant = copy;
  // Half of the energy comes 60 ms later: until then the curve is at -3 dB after the direct sound.
  for (std::int64_t i = 2 * kSamples - 1; i >= 0; --i) {
    if (i % kSamples >= 960) reverberant.target[i] += reverberant.target[i - 960];
  }
  const auto decay = [&](const TrainingBatch& batch) {
    GtfLearnerOptions with;
    with.loss.decay = 1.0;
    return added_loss(d, with, {}, batch);
  };
  EXPECT_LT(decay(copy), 0.5 * decay(reverberant));
  EXPECT_GT(decay(reverberant), 3.0);
}

TEST(GtfLearner, ReverberationTimesCountAsTheEstimatorHearsThem) {
  // The untrained network returns its input, except for mixed phases.
  const GtfDescription d = small();
  constexpr std::int64_t kSecond = Rt60Description::kWindowSamples;
  const GtfWeights weights = initial_gtf_weights(d, head(), 1);
  TrainingBatch copy = batch_for(d, 1, kSecond);
  copy.target = GtfLearner(weights).predict(copy);
  TrainingBatch faded = copy;
  for (std::int64_t i = 0; i < 2 * kSecond; ++i) {
    faded.target[i] *= std::exp(-6.9F * static_cast<float>(i % kSecond) / 8000.0F);
  }
  GtfLearnerOptions with;
  with.loss.reverberation = 1.0;
  with.estimator = initial_rt60_weights({2, 1.0}, 5);
  const auto counted = [&](const TrainingBatch& batch) { return added_loss(d, with, {}, batch); };
  Rt60Estimator engine(*with.estimator);
  double wanted = 0.0;
  for (std::int64_t ear = 0; ear < 2; ++ear) {
    const auto time_of = [&](const TrainingBatch& batch) {
      return engine.estimate_second_s(std::span(batch.target).subspan(ear * kSecond, kSecond));
    };
    wanted += std::abs(time_of(copy) - time_of(faded)) / 2;
  }
  ASSERT_GT(wanted, 0.01);
  // Eighteen float32 layers twice, magnitudes of 3e-4 and more, and the difference of two losses.
  EXPECT_NEAR(counted(copy), 0.0, 1e-5);
  EXPECT_NEAR(counted(faded), wanted, 0.02 * wanted);
}

}  // namespace
}  // namespace earpoint
