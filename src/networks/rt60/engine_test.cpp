#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/network_testing/oracle_weights.h>
#include <earpoint/rt60/description.h>
#include <earpoint/rt60/engine.h>
#include <earpoint/rt60/weights.h>
#include <earpoint/vigas/weights.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

const fs::path kData = EARPOINT_SOURCE_DIR "/src/networks/rt60/testdata";

/// A narrow estimator with weights by formula.
Rt60EstimatorWeights small_weights(std::optional<double> input_rms) {
  Rt60EstimatorWeights weights{{2, input_rms}, {}, {}};
  for (const auto& [name, shape] : required_tensors(weights.description)) {
    const OracleRandom random(name, 1);
    std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()));
    const double low = name.ends_with("running_var") ? 0.5 : -0.5;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = random.value(i, low, 1.0);
    weights.tensors[name] = make_tensor<float>(values, shape);
  }
  return weights;
}

Waveform noise(std::ptrdiff_t samples, double gain) {
  Waveform sound(1, samples, Rt60Description::kSampleRateHz);
  const OracleRandom random("noise", 2);
  for (std::ptrdiff_t i = 0; i < samples; ++i) sound.channel(0)[i] = random.value(i, -gain, gain);
  return sound;
}

TEST(Rt60Estimator, AgreesWithTheReleasedCode) {
  const Rt60EstimatorWeights weights = rt60_estimator_weights(
      weight_file_from_checkpoint(make_oracle_checkpoint(kData / "rt60_weights.json"),
                                  KeepTensors::required, "manifest"),
      "manifest");
  Rt60Estimator estimator(weights, 2);
  const SafetensorsFile expected = read_safetensors(kData / "rt60.safetensors");
  const auto sound = expected.tensors.at("wav").as<float>();
  const auto features = expected.tensors.at("feature").as<float>();
  const auto seconds = expected.tensors.at("rt60").as<float>();
  const std::size_t width = features.size() / seconds.size();
  const double scale = *std::max_element(features.begin(), features.end());
  for (std::size_t clip = 0; clip < seconds.size(); ++clip) {
    const double found =
        estimator.estimate_second_s(sound.subspan(clip * sound.size() / seconds.size(), 16000));
    // Eighteen float32 layers: the released code itself differs from float64 by this much. The last
    // layer adds up the features.
    ASSERT_EQ(estimator.feature().size(), width);
    for (std::size_t i = 0; i < width; ++i) {
      EXPECT_NEAR(estimator.feature()[i], features[clip * width + i], 1e-5 * scale) << i;
    }
    EXPECT_NEAR(found, seconds[clip], 2e-5 * scale);
  }
}

TEST(Rt60Estimator, HearsEveryChannelByItself) {
  Rt60Estimator estimator(small_weights({}));
  const Waveform loud = noise(16000, 0.5);
  const Waveform quiet = noise(16000, 0.1);
  Waveform both(2, 16000, 16000);
  std::ranges::copy(loud.channel(0), both.channel(0).begin());
  std::ranges::copy(quiet.channel(0), both.channel(1).begin());
  const std::vector<double> found = estimator.estimate_s(both);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0], estimator.estimate_s(loud)[0]);
  EXPECT_EQ(found[1], estimator.estimate_s(quiet)[0]);
  EXPECT_NE(found[0], found[1]);
}

TEST(Rt60Estimator, AveragesTheWholeSecondsOfALongSound) {
  Rt60Estimator estimator(small_weights({}));
  const Waveform sound = noise(40000, 0.3);
  const double first = estimator.estimate_second_s(sound.channel(0).subspan(0, 16000));
  const double second = estimator.estimate_second_s(sound.channel(0).subspan(16000, 16000));
  EXPECT_NE(first, second);
  EXPECT_DOUBLE_EQ(estimator.estimate_s(sound)[0], (first + second) / 2);
}

TEST(Rt60Estimator, ContinuesAShortSoundWithZeros) {
  Rt60Estimator estimator(small_weights({}));
  const Waveform sound = noise(5000, 0.3);
  std::vector<float> filled(16000);
  std::ranges::copy(sound.channel(0), filled.begin());
  EXPECT_EQ(estimator.estimate_s(sound)[0], estimator.estimate_second_s(filled));
}

TEST(Rt60Estimator, OfScaledInputDoesNotHearTheLevel) {
  Rt60Estimator scaled(small_weights(0.1));
  Rt60Estimator unscaled(small_weights({}));
  const Waveform loud = noise(16000, 0.5);
  const Waveform quiet = noise(16000, 0.5 / 64);  // the same samples, but for a power of two
  EXPECT_NE(unscaled.estimate_s(loud)[0], unscaled.estimate_s(quiet)[0]);
  EXPECT_EQ(scaled.estimate_s(loud)[0], scaled.estimate_s(quiet)[0]);
}

TEST(Rt60Estimator, HasAFiniteAnswerToSilence) {
  Rt60Estimator estimator(small_weights(0.1));
  EXPECT_TRUE(std::isfinite(estimator.estimate_s(Waveform(1, 16000, 16000))[0]));
}

}  // namespace
}  // namespace earpoint
