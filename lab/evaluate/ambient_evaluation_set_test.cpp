#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/core/random.h>
#include <earpoint/dataset/ambient.h>
#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/evaluate/evaluation_set.h>
#include <earpoint/evaluate/method.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/network_testing/random_weights.h>
#include <earpoint/vigas/weights.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class AmbientEvaluationSetTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("ambient_set." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    write_tiny_dataset(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::unique_ptr<EvaluationSet> quiet() const {
    return soundspaces_evaluation_set(folder_, "test", {}, {}, 10 << 20);
  }

  /// A network of random weights. @param separated  whether it was trained without ambient sound
  [[nodiscard]] MethodEntry network(bool separated) const {
    ViGasDescription description;
    description.pose_encoding = PoseEncoding::full;
    description.inputs = {{"tgt_pose", 3}, {"tgt_rotation", 6}};
    description.fusion_width = 8;
    description.conditioning_width = 8;
    description.channels = 8;
    description.blocks = 1;
    description.layers_per_block = 2;
    if (separated) description.highpass_cutoff_hz = kSeparationCutoffHz;
    ViGasWeights weights{.description = description, .tensors = {}, .unused = {}};
    RandomStream random(1);
    weights.tensors = random_tensors(required_tensors(description), random, -0.3, 0.3);
    const fs::path path = folder_ / (separated ? "separated.safetensors" : "whole.safetensors");
    write_safetensors(path, to_weight_file(weights));
    return network_method(path.stem().string(), path.string());
  }

  fs::path folder_;
};

bool equal(const Waveform& a, const Waveform& b) {
  return std::ranges::equal(a.planar(), b.planar());
}

TEST_F(AmbientEvaluationSetTest, EveryPairHasItsOwnNoiseAndACleanTarget) {
  const auto clean = quiet();
  const auto noisy = with_ambient(quiet(), -30.0);
  const auto again = with_ambient(quiet(), -30.0);
  ASSERT_EQ(noisy->size(), clean->size());
  std::vector<float> last;
  for (std::size_t pair = 0; pair < noisy->size(); ++pair) {
    const PairSample without = clean->sample(pair);
    const PairSample with = noisy->sample(pair);
    EXPECT_TRUE(equal(with.target, without.target));
    EXPECT_TRUE(equal(with.source, again->sample(pair).source));
    ASSERT_TRUE(with.ambient.has_value());
    std::vector<float> noise;
    double energy = 0.0;
    for (std::size_t i = 0; i < with.source.planar().size(); ++i) {
      noise.push_back(with.source.planar()[i] + with.ambient->planar()[i] -
                      without.source.planar()[i]);
      energy += double{noise.back()} * noise.back();
    }
    // Two ears have some 80 independent values in a second: a standard error of 0.7 dB, four times.
    EXPECT_NEAR(10.0 * std::log10(energy / static_cast<double>(noise.size())), -30.0, 3.0);
    EXPECT_NE(noise, last);
    last = noise;
    EXPECT_EQ(noisy->name(pair), clean->name(pair));
    EXPECT_EQ(noisy->cluster(pair), clean->cluster(pair));
    EXPECT_TRUE(noisy->truth(pair).has_value());
  }
}

TEST_F(AmbientEvaluationSetTest, TheWindowsNoiseIsTheSameWithSoundBefore) {
  constexpr std::ptrdiff_t kContext = 8000;
  const auto with_context = [&](AmbientSeparation kind) {
    return with_ambient(soundspaces_evaluation_set(folder_, "test", {}, {}, 10 << 20,
                                                   PairTarget::viewpoint, kContext),
                        -30.0, kind);
  };
  const PairSample alone = with_ambient(quiet(), -30.0)->sample(0);
  const PairSample more = with_context(AmbientSeparation::bandpass)->sample(0);
  const PairSample window = without_context(more);
  ASSERT_EQ(window.source.samples(), alone.source.samples());
  double before = 0.0;
  for (int ear = 0; ear < 2; ++ear) {
    for (std::ptrdiff_t i = 0; i < window.source.samples(); ++i) {
      // Both convolve in float32 by transforms of different sizes.
      ASSERT_NEAR(window.source.channel(ear)[i] + window.ambient->channel(ear)[i],
                  alone.source.channel(ear)[i] + alone.ambient->channel(ear)[i], 2e-6);
    }
    for (std::ptrdiff_t i = 0; i < kContext; ++i) {
      before += std::pow(
          more.source.channel(ear)[i] + more.ambient->channel(ear)[i] - more.clean->channel(ear)[i],
          2);
    }
  }
  // Half a second of noise has 20 independent values for each ear: a standard error of 1 dB, three
  // times.
  EXPECT_NEAR(10.0 * std::log10(before / (2 * kContext)), -30.0, 3.0);
}

TEST_F(AmbientEvaluationSetTest, SeparatesAsItIsAsked) {
  const PairSample band = with_ambient(quiet(), -30.0)->sample(0);
  const PairSample mmse = with_ambient(quiet(), -30.0, AmbientSeparation::mmse)->sample(0);
  EXPECT_FALSE(equal(band.source, mmse.source));
  for (std::size_t i = 0; i < band.source.planar().size(); ++i) {
    // Both pairs add up to the same sound; each part is rounded to single precision.
    ASSERT_NEAR(mmse.source.planar()[i] + mmse.ambient->planar()[i],
                band.source.planar()[i] + band.ambient->planar()[i], 2e-7);
  }
}

TEST_F(AmbientEvaluationSetTest, OnlyNetworksTrainedWithAmbientSoundHearIt) {
  const PairSample sample = with_ambient(quiet(), -30.0)->sample(0);
  PairSample primary = sample;
  primary.ambient.reset();
  PairSample whole = primary;
  for (std::size_t i = 0; i < whole.source.planar().size(); ++i) {
    whole.source.planar()[i] += sample.ambient->planar()[i];
  }
  const auto answer = [&](bool separated, const PairSample& asked) {
    return network(separated).make()->render({asked, "room"});
  };
  EXPECT_TRUE(equal(answer(true, sample), answer(true, primary)));
  EXPECT_FALSE(equal(answer(false, sample), answer(false, primary)));
  // It gets the whole sound, and the primary sound of its output is compared.
  PairSample expected;
  expected.source = answer(false, whole);
  separate_source(expected);
  EXPECT_TRUE(equal(answer(false, sample), expected.source));
}

}  // namespace
}  // namespace earpoint
