#include "drawn_gtf.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/core_testing/allocation_count.h>
#include <earpoint/gtf/engine.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

using gtf::engine_that_looks;
using gtf::kHere;
using gtf::kHop;
using gtf::kSamples;
using gtf::kThere;
using gtf::noise;
using gtf::random_weights;
using gtf::small;
using gtf::streamed;

/// Kernels over past frames and tails that do not depend on sound or pose; gains that depend on the
/// pose.
GtfWeights steady_weights(const GtfDescription& d) {
  GtfWeights weights = random_weights(d);
  for (auto& [name, tensor] : weights.tensors) {
    if (!name.starts_with("kernel.") && name != "gain.weight") continue;
    const float value = name == "kernel.bias" ? 0.1F : 0.0F;
    tensor = make_tensor<float>(
        std::vector<float>(static_cast<std::size_t>(tensor.elements()), value), tensor.shape);
  }
  return weights;
}

TEST(Gtf, LouderInGivesLouderOut) {
  Gtf engine = engine_that_looks(small());
  std::vector<float> source = noise(2 * kSamples, 0.1, 2);
  std::vector<float> first(source.size());
  std::vector<float> louder(source.size());
  engine.synthesize(source, first);
  for (float& sample : source) sample *= 0.25F;  // a power of two: no rounding
  engine.synthesize(source, louder);
  for (std::size_t i = 0; i < first.size(); ++i)
    ASSERT_NEAR(louder[i], 0.25F * first[i], 1e-6) << i;
  EXPECT_GT(std::ranges::max(first), 0.01F) << "a tenth of the noise that goes in";
}

TEST(Gtf, AllocatesNothingAfterTheFirstWindow) {
  GtfDescription d = small();
  d.phase_rounds = 2;
  d.sight_points = 2;
  d.texture = true;
  Gtf engine = engine_that_looks(d);
  const std::vector<float> source = noise(2 * kSamples, 0.1, 2);
  const std::vector<float> picture = noise(3 * 32 * 32, 0.3, 5);
  std::vector<float> output(source.size());
  std::vector<float> hop(2 * kHop);
  AllocationCount counted;
  engine.ask_for_texture(0.5);
  engine.set_picture(picture, Box{0.1, 0.2, 0.3, 0.4});
  engine.set_pose({}, Vector3{1, 1, 0});
  engine.synthesize(source, output);
  engine.start();
  for (int i = 0; i < 20; ++i) {
    engine.set_pose({{0.1 * i, 0, 0}, {}});
    engine.advance(std::span(source).first(2 * kHop), hop);
  }
  EXPECT_EQ(counted.count(), 0);
}

TEST(Gtf, TakesTheSpeakersPlaceWhenItIsTold) {
  Gtf engine = engine_that_looks(small());
  const std::vector<float> source = noise(2 * kSamples, 0.1, 2);
  std::vector<float> guessed(source.size());
  std::vector<float> told(source.size());
  engine.synthesize(source, guessed);
  const Vector3 place = engine.speaker_m().value();
  engine.set_pose({{1, 2, 0}, quaternion_from_euler({.yaw_rad = 0.3})}, place);
  engine.synthesize(source, told);
  EXPECT_EQ(told, guessed);
  engine.set_pose({{1, 2, 0}, quaternion_from_euler({.yaw_rad = 0.3})}, -place);
  engine.synthesize(source, told);
  EXPECT_NE(told, guessed);
  EXPECT_EQ(engine.speaker_m().value(), -place);
}

TEST(Gtf, ItsTrainingRangeDecidesWhichMovesAreShortened) {
  const std::vector<float> source = noise(2 * kSamples, 0.1, 2);
  const auto heard_at = [&](double distance_m, double farthest_m) {
    GtfDescription d = small();
    d.training_range.farthest_move_m = farthest_m;
    Gtf engine = engine_that_looks(d);
    engine.set_pose({{distance_m, 0, 0}, {}}, Vector3{1, 1, 0});
    std::vector<float> output(source.size());
    engine.synthesize(source, output);
    return output;
  };
  EXPECT_EQ(heard_at(4.0, 5.0), heard_at(4.0, 8.0));
  EXPECT_EQ(heard_at(7.0, 8.0), heard_at(7.0, 9.0));
  EXPECT_NE(heard_at(7.0, 5.0), heard_at(7.0, 8.0));
}

TEST(Gtf, LocatesTheSpeakerWhereItRendersThem) {
  Gtf engine = engine_that_looks(small());
  const std::vector<float> source = noise(2 * kSamples, 0.1, 2);
  const GtfSpeaker found = engine.locate(source).value();
  std::vector<float> output(source.size());
  engine.synthesize(source, output);
  EXPECT_EQ(found.position_m, engine.speaker_m().value());
  EXPECT_GE(found.yaw_certainty, 0.0);
  EXPECT_LE(found.yaw_certainty, 1.0);
  GtfDescription blind = small();
  blind.geometry = blind.delays = false;
  EXPECT_FALSE(engine_that_looks(blind).locate(source).has_value());
}

TEST(Gtf, AMovingTargetIsHeardAtEachOfItsPlaces) {
  const GtfDescription d = small();
  Gtf engine = engine_that_looks(d);
  const std::vector<float> source = noise(2 * kSamples, 0.1, 2);
  std::vector<float> window(source.size());
  engine.synthesize(source, window);
  const GtfStatistics statistics = engine.statistics();
  const Pose here{{1, 2, 0}, {}};
  const Pose there{{-1, 0.5, 0}, quaternion_from_euler({.yaw_rad = 2})};
  const auto standing = [&](const Pose& pose) {
    engine.set_pose(pose);
    engine.start(statistics);
    return streamed(engine, source, [](std::size_t) {});
  };
  const std::vector<float> at_first = standing(here);
  const std::vector<float> at_last = standing(there);
  engine.set_pose(here);
  engine.start(statistics);
  constexpr std::size_t kTurn = 25;
  const std::vector<float> moving = streamed(engine, source, [&](std::size_t hop) {
    if (hop == kTurn) engine.set_pose(there);
  });
  const auto latency = static_cast<std::size_t>(engine.latency_samples());
  // Until the turn it equals the first place. Once the trunk has forgotten the old conditions (it
  // reaches 62 frames, but they fade), it is nearer to the second place than the two are apart.
  for (std::size_t i = 0; i < kTurn * kHop; ++i) ASSERT_EQ(moving[i], at_first[i]) << i;
  double to_last = 0.0;
  double apart = 0.0;
  for (std::size_t i = kTurn * kHop + latency; i < kSamples; ++i) {
    to_last += std::pow(moving[i] - at_last[i], 2);
    apart += std::pow(at_first[i] - at_last[i], 2);
  }
  EXPECT_LT(to_last, 0.05 * apart);
}

constexpr std::size_t kFrames = 1 + 2 * kSamples / kHop;  // of twice kSamples

/// A walk from one place to the other, all the way.
std::vector<Pose> walk() {
  std::vector<Pose> path;
  for (std::size_t i = 0; i < kFrames; ++i) {
    path.push_back(interpolate(kHere, kThere, static_cast<double>(i) / (kFrames - 1)));
  }
  return path;
}

std::vector<float> along(Gtf& engine, std::span<const float> source, std::span<const Pose> path) {
  std::vector<float> result(source.size());
  engine.synthesize(source, path, result);
  return result;
}

TEST(Gtf, APathThatStandsStillEqualsStandingStill) {
  Gtf engine = engine_that_looks(small());
  const std::vector<float> source = noise(4 * kSamples, 0.1, 2);
  std::vector<float> still(source.size());
  engine.set_pose(kThere);
  engine.synthesize(source, still);
  engine.set_pose(kHere);
  EXPECT_EQ(along(engine, source, std::vector<Pose>(kFrames, kThere)), still);
}

TEST(Gtf, APathThatJumpsEqualsBothOfItsPlacesAwayFromTheJump) {
  const GtfDescription d = small();
  Gtf engine = engine_that_looks(d);
  const std::vector<float> source = noise(4 * kSamples, 0.1, 2);
  constexpr std::size_t kJump = 25;
  std::vector<Pose> path(kFrames, kThere);
  std::fill_n(path.begin(), kJump, kHere);
  const std::vector<float> at_first = along(engine, source, std::vector<Pose>(kFrames, kHere));
  const std::vector<float> at_last = along(engine, source, std::vector<Pose>(kFrames, kThere));
  const std::vector<float> jumping = along(engine, source, path);
  // A frame reaches 200 samples to either side. Only the trunk remembers the old place, over twice
  // the sum of its dilations.
  std::size_t memory = 0;
  for (int i = 0; i < d.layers; ++i) memory += 2 * static_cast<std::size_t>(d.dilation(i));
  const std::size_t last_old = kJump * kHop - 200;
  const std::size_t first_new = (kJump + memory) * kHop + 200;
  ASSERT_LT(first_new, 2 * kSamples - 1000);
  for (std::size_t ear = 0; ear < 2; ++ear) {
    const std::size_t offset = ear * 2 * kSamples;
    // Only the blocks differ, and they do not change the order of any sum.
    for (std::size_t i = 0; i < last_old; ++i) {
      ASSERT_NEAR(jumping[offset + i], at_first[offset + i], 1e-6) << i;
    }
    for (std::size_t i = first_new; i < 2 * kSamples; ++i) {
      ASSERT_NEAR(jumping[offset + i], at_last[offset + i], 1e-6) << i;
    }
  }
  EXPECT_NE(at_first, at_last);
}

TEST(Gtf, AStreamThatIsAimedAtEveryHopEqualsAWindowAlongThePath) {
  const GtfDescription d = small();
  Gtf engine = engine_that_looks(d);
  const std::vector<float> source = noise(4 * kSamples, 0.1, 2);
  const std::vector<Pose> path = walk();
  const std::vector<float> window = along(engine, source, path);
  engine.start(engine.statistics());
  // In hop h frame h - 1 is complete, and the frame that is earlier by the look-ahead comes out.
  const auto late = static_cast<std::size_t>(1 + d.needed_ahead());
  const std::vector<float> stream = streamed(
      engine, source, [&](std::size_t hop) { engine.set_pose(path[hop < late ? 0 : hop - late]); });
  const auto latency = static_cast<std::size_t>(engine.latency_samples());
  for (std::size_t i = 0; i + latency + 2 * kHop < 2 * kSamples; ++i) {
    ASSERT_NEAR(stream[latency + i], window[i], 1e-6) << i;
  }
}

TEST(Gtf, ASmoothWalkHasNoClicks) {
  Gtf engine(steady_weights(small()));
  engine.set_picture(std::vector<float>(std::size_t{3} * 32 * 32), {});
  std::vector<float> tone(4 * kSamples);
  for (std::size_t i = 0; i < tone.size(); ++i) {
    tone[i] = static_cast<float>(0.1 * std::sin(2 * kPi * 330.0 / 16000 * static_cast<double>(i)));
  }
  // The greatest second difference: h for a step of height h, and 0.017 times its amplitude for the
  // tone.
  const auto bend = [](std::span<const float> sound) {
    float greatest = 0.0F;
    for (std::size_t i = 1000; i + 1000 < sound.size() / 2; ++i) {
      greatest = std::max(greatest, std::abs(sound[i - 1] - 2 * sound[i] + sound[i + 1]));
    }
    return greatest;
  };
  const std::vector<Pose> path = walk();
  float standing = 0.0F;
  for (std::size_t stop = 0; stop < kFrames; stop += 10) {
    standing =
        std::max(standing, bend(along(engine, tone, std::vector<Pose>(kFrames, path[stop]))));
  }
  // While moving the network may be slightly louder than at fixed places.
  EXPECT_LT(bend(along(engine, tone, path)), 1.1F * standing);
}

TEST(Gtf, AStreamsRunningLevelCancelsWhenItJumps) {
  // Whatever the level that scaled a frame, it must come out as loud as it went in.
  GtfDescription d = small();
  d.delays = false;
  GtfWeights weights = steady_weights(d);
  for (const char* name : {"gain.static.weight", "gain.static.bias"}) {
    Tensor& tensor = weights.tensors.at(name);
    tensor = make_tensor<float>(std::vector<float>(static_cast<std::size_t>(tensor.elements())),
                                tensor.shape);
  }
  Gtf engine(weights);
  std::vector<float> source = noise(4 * kSamples, 0.1, 2);
  for (std::size_t ear = 0; ear < 2; ++ear) {
    for (std::size_t i = 0; i < kSamples; ++i) source[ear * 2 * kSamples + i] *= 0.01F;
  }
  std::vector<float> window(source.size());
  engine.synthesize(source, window);
  engine.start(engine.statistics());
  const std::vector<float> held = streamed(engine, source, [](std::size_t) {});
  engine.start();
  const std::vector<float> running = streamed(engine, source, [](std::size_t) {});
  for (std::size_t i = 0; i < held.size(); ++i) {
    // The floor of magnitudes in the kernels is a fiftieth of a quiet bin at either level.
    ASSERT_NEAR(running[i], held[i], 0.002) << i;
  }
}

TEST(Gtf, AStreamOnItsOwnSettlesOnTheStatisticsOfASteadySound) {
  const GtfDescription d = small();
  Gtf engine = engine_that_looks(d);
  const std::vector<float> source = noise(2 * 4 * kSamples, 0.1, 2);
  std::vector<float> window(source.size());
  engine.synthesize(source, window);
  const GtfStatistics whole = engine.statistics();
  engine.start();
  static_cast<void>(streamed(engine, source, [](std::size_t) {}));
  // A second of noise: its level is known to 1 in sqrt(32000).
  EXPECT_NEAR(engine.statistics().level, whole.level, 0.02 * whole.level);
  const auto bands = static_cast<std::size_t>(d.bands);
  for (std::size_t i = 0; i < whole.summary.size(); ++i) {
    // A running mean over the last of two seconds against the mean of both: by chance features of
    // noise differ with a standard deviation of 0.025, and levels of bands of 0.002. Four of them.
    const bool is_level = i >= 3 * bands && i < 4 * bands;
    EXPECT_NEAR(engine.statistics().summary[i], whole.summary[i], is_level ? 0.008 : 0.1) << i;
  }
}

TEST(Gtf, HasAnAnswerToSilence) {
  Gtf engine = engine_that_looks(small());
  std::vector<float> output(2 * kSamples, 1.0F);  // which the engine must overwrite
  engine.synthesize(std::vector<float>(2 * kSamples), output);
  for (const float sample : output) ASSERT_TRUE(std::abs(sample) < 1e-3F);
}

}  // namespace
}  // namespace earpoint
