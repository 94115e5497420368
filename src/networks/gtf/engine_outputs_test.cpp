#include "drawn_gtf.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/stft.h>
#include <earpoint/gtf/engine.h>

namespace earpoint {
namespace {

using gtf::engine_that_looks;
using gtf::kHop;
using gtf::kSamples;
using gtf::kThere;
using gtf::noise;
using gtf::random_weights;
using gtf::small;
using gtf::streamed;

/// The mean difference between the short-time magnitudes of two planar sounds.
double magnitude_difference(std::span<const float> a, std::span<const float> b) {
  Stft stft;
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t ear = 0; ear < 2; ++ear) {
    const Spectrogram x = stft.forward(a.subspan(ear * kSamples, kSamples));
    const Spectrogram y = stft.forward(b.subspan(ear * kSamples, kSamples));
    for (std::size_t i = 0; i < x.values.size(); ++i) {
      sum += std::abs(std::abs(x.values[i]) - std::abs(y.values[i]));
      ++count;
    }
  }
  return sum / static_cast<double>(count);
}

/// @param latency  32.5 ms, and 20 ms more for each phase round
void expect_a_stream_equals_a_window(const GtfDescription& d, std::size_t latency_samples) {
  Gtf engine = engine_that_looks(d);
  const std::vector<float> source = noise(2 * kSamples, 0.1, 2);
  std::vector<float> window(source.size());
  engine.synthesize(source, window);
  engine.start(engine.statistics());
  const std::vector<float> stream = streamed(engine, source, [](std::size_t) {});
  const auto latency = static_cast<std::size_t>(engine.latency_samples());
  ASSERT_EQ(latency, latency_samples);
  for (std::size_t ear = 0; ear < 2; ++ear) {
    for (std::size_t i = 0; i < latency; ++i) EXPECT_EQ(stream[ear * kSamples + i], 0.0F);
    // Frames at the window's end lack the sound after it, and so do the frames before them that a
    // round of phases reaches.
    const std::size_t unsure = (2 + static_cast<std::size_t>(d.phase_ahead())) * kHop;
    for (std::size_t i = 0; i + latency + unsure < kSamples; ++i) {
      // Only the blocks differ, and they do not change the order of any sum.
      ASSERT_NEAR(stream[ear * kSamples + latency + i], window[ear * kSamples + i], 1e-6) << i;
    }
  }
}

TEST(Gtf, AStreamEqualsAWindowOfTheSameStatistics) {
  expect_a_stream_equals_a_window(small(), 680);
}

TEST(Gtf, AStreamOfAgreeingPhasesEqualsAWindowAndIsTwoFramesLaterARound) {
  GtfDescription d = small();
  d.phase_rounds = 2;
  expect_a_stream_equals_a_window(d, 680 + 4 * kHop);
}

TEST(Gtf, AStreamMaySkipRoundsToBeInTimeSooner) {
  GtfDescription d = small();
  const std::vector<float> source = noise(2 * kSamples, 0.1, 2);
  Gtf without = engine_that_looks(d);
  std::vector<float> window(source.size());
  without.synthesize(source, window);
  d.phase_rounds = 2;
  Gtf engine = engine_that_looks(d);
  engine.start(without.statistics(), 0);
  EXPECT_EQ(engine.latency_samples(), without.latency_samples());
  const std::vector<float> skipped = streamed(engine, source, [](std::size_t) {});
  without.start(without.statistics());
  EXPECT_EQ(streamed(without, source, [](std::size_t) {}), skipped);
  engine.start(without.statistics(), 1);
  EXPECT_EQ(engine.latency_samples(), without.latency_samples() + 2 * kHop);
}

/// The error of the sound's short-time magnitudes can only be measured for a network whose filter
/// is known: an identity whose phases are those of the wrong place.
TEST(Gtf, RoundsOfPhasesMakeFramesAgree) {
  GtfDescription d = small();
  const std::vector<float> source = noise(2 * kSamples, 0.1, 2);
  std::vector<double> errors;
  for (const int rounds : {0, 1, 4}) {
    d.phase_rounds = rounds;
    GtfWeights weights = random_weights(d);
    for (auto& [name, tensor] : weights.tensors) {
      if (!name.starts_with("kernel") && !name.starts_with("gain")) continue;
      std::vector<float> values(static_cast<std::size_t>(tensor.elements()));
      if (name == "kernel.bias") {
        for (int ear = 0; ear < 2; ++ear) {
          std::fill_n(values.begin() + (3 * ear * d.taps() + d.past_frames) * d.bands, d.bands,
                      1.0F);
        }
      }
      tensor = make_tensor<float>(values, tensor.shape);
    }
    Gtf engine(weights);
    engine.set_picture(std::vector<float>(std::size_t{3} * 32 * 32), {});
    engine.set_pose(kThere);
    std::vector<float> output(source.size());
    engine.synthesize(source, output);
    errors.push_back(magnitude_difference(output, source));
  }
  EXPECT_LT(errors[1], errors[0]);
  EXPECT_LT(errors[2], errors[1]);
}

TEST(Gtf, TellsTheVoiceByAGainOfWhatBothEarsHear) {
  GtfDescription d = small();
  d.dry_voice = true;
  GtfWeights weights = random_weights(d);
  // No delay between the ears.
  for (auto& [name, tensor] : weights.tensors) {
    if (!name.starts_with("dry.") && name != "head.delay_s") continue;
    const float value = name == "dry.bias" ? std::log(2.0F) : 0.0F;
    tensor = make_tensor<float>(
        std::vector<float>(static_cast<std::size_t>(tensor.elements()), value), tensor.shape);
  }
  Gtf engine(weights);
  engine.set_picture(std::vector<float>(std::size_t{3} * 32 * 32), {});
  engine.set_pose(kThere);
  std::vector<float> source = noise(2 * kSamples, 0.1, 2);
  std::copy_n(source.begin(), kSamples, source.begin() + kSamples);
  std::vector<float> before(source.size());
  engine.synthesize(source, before);
  std::vector<float> voice(kSamples);
  engine.tell_voice(source, voice);
  for (std::size_t i = 0; i < kSamples; ++i) {
    // The floor of 1e-3 under magnitudes of order 1, at a level of 0.05, twice.
    ASSERT_NEAR(voice[i], 2.0F * source[i], 2e-3) << i;
  }
  // And the voice has not changed what it renders.
  std::vector<float> after(source.size());
  engine.synthesize(source, after);
  EXPECT_EQ(after, before);
}

TEST(Gtf, AsksForATextureOnlyWhereThereAreTwo) {
  GtfDescription d = small();
  for (const bool has_two : {false, true}) {
    d.texture = has_two;
    Gtf engine = engine_that_looks(d);
    const std::vector<float> source = noise(2 * kSamples, 0.1, 2);
    std::vector<float> natural(source.size());
    std::vector<float> mean(source.size());
    engine.synthesize(source, natural);
    engine.ask_for_texture(0);
    engine.synthesize(source, mean);
    EXPECT_EQ(mean != natural, has_two);
    engine.ask_for_texture(1);
    engine.synthesize(source, mean);
    EXPECT_EQ(mean, natural);
  }
}

}  // namespace
}  // namespace earpoint
