#include "allocation_count.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/pose.h>
#include <earpoint/core/random.h>
#include <earpoint/infer/gtf.h>

namespace earpoint {
namespace {

constexpr std::size_t kSamples = 8000;
constexpr std::size_t kHop = GtfDescription::kHop;

std::vector<float> noise(std::size_t count, double size, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(size * random.normal());
  return values;
}

GtfDescription small() {
  GtfDescription d;
  d.channels = 20;
  d.layers = 6;
  d.bands = 12;
  d.picture_px = 32;
  d.window_samples = kSamples;
  return d;
}

/// Random weights; tables of a head that is all level and delay.
GtfWeights random_weights(const GtfDescription& d) {
  GtfWeights weights{d, {}, {}};
  std::uint64_t seed = 1;
  for (const auto& [name, shape] : required_tensors(d)) {
    std::vector<float> values =
        noise(static_cast<std::size_t>(element_count(shape).value()), 0.1, seed++);
    if (name.find("power") != std::string::npos) {
      for (float& value : values) value = 0.5F + std::abs(value);
    }
    if (name == "head.delay_s") {
      for (float& value : values) value *= 1e-3F;
    }
    weights.tensors[name] = make_tensor<float>(values, shape);
  }
  return weights;
}

Gtf engine_that_looks(const GtfDescription& d) {
  Gtf engine(random_weights(d));
  engine.look(noise(static_cast<std::size_t>(3 * d.picture_px * d.picture_px), 0.3, 5),
              Box{0.1, 0.2, 0.3, 0.4});
  engine.aim({{1, 2, 0}, quaternion_from_euler({.yaw_rad = 0.3})});
  return engine;
}

/// Runs a planar sound through a stream that has begun. Calls before(hop) before each hop.
template <typename Before>
std::vector<float> streamed(Gtf& engine, std::span<const float> source, const Before& before) {
  const std::size_t samples = source.size() / 2;
  std::vector<float> result(source.size());
  std::vector<float> in(2 * kHop);
  std::vector<float> out(2 * kHop);
  for (std::size_t hop = 0; (hop + 1) * kHop <= samples; ++hop) {
    before(hop);
    for (std::size_t ear = 0; ear < 2; ++ear) {
      std::copy_n(source.begin() + ear * samples + hop * kHop, kHop, in.begin() + ear * kHop);
    }
    engine.advance(in, out);
    for (std::size_t ear = 0; ear < 2; ++ear) {
      std::copy_n(out.begin() + ear * kHop, kHop, result.begin() + ear * samples + hop * kHop);
    }
  }
  return result;
}

TEST(Gtf, AStreamEqualsAWindowOfTheSameStatistics) {
  Gtf engine = engine_that_looks(small());
  const std::vector<float> source = noise(2 * kSamples, 0.1, 2);
  std::vector<float> window(source.size());
  engine.synthesize(source, window);
  engine.start(engine.statistics());
  const std::vector<float> stream = streamed(engine, source, [](std::size_t) {});
  const auto latency = static_cast<std::size_t>(engine.latency_samples());
  EXPECT_EQ(latency, 680U);
  for (std::size_t ear = 0; ear < 2; ++ear) {
    for (std::size_t i = 0; i < latency; ++i) EXPECT_EQ(stream[ear * kSamples + i], 0.0F);
    // The window's end is heard without what comes after it.
    for (std::size_t i = 0; i + latency + 2 * kHop < kSamples; ++i) {
      // Only blocks differ, and the order of no sum depends on them.
      ASSERT_NEAR(stream[ear * kSamples + latency + i], window[ear * kSamples + i], 1e-6) << i;
    }
  }
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
}

TEST(Gtf, AllocatesNothingAfterTheFirstWindow) {
  Gtf engine = engine_that_looks(small());
  const std::vector<float> source = noise(2 * kSamples, 0.1, 2);
  const std::vector<float> picture = noise(3 * 32 * 32, 0.3, 5);
  std::vector<float> output(source.size());
  std::vector<float> hop(2 * kHop);
  infer::AllocationCount counted;
  engine.look(picture, Box{0.1, 0.2, 0.3, 0.4});
  engine.aim({}, Vector3{1, 1, 0});
  engine.synthesize(source, output);
  engine.start();
  for (int i = 0; i < 20; ++i) {
    engine.aim({{0.1 * i, 0, 0}, {}});
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
  engine.aim({{1, 2, 0}, quaternion_from_euler({.yaw_rad = 0.3})}, place);
  engine.synthesize(source, told);
  EXPECT_EQ(told, guessed);
  engine.aim({{1, 2, 0}, quaternion_from_euler({.yaw_rad = 0.3})}, -place);
  engine.synthesize(source, told);
  EXPECT_NE(told, guessed);
  EXPECT_EQ(engine.speaker_m().value(), -place);
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
    engine.aim(pose);
    engine.start(statistics);
    return streamed(engine, source, [](std::size_t) {});
  };
  const std::vector<float> at_first = standing(here);
  const std::vector<float> at_last = standing(there);
  engine.aim(here);
  engine.start(statistics);
  constexpr std::size_t kTurn = 25;
  const std::vector<float> moving = streamed(engine, source, [&](std::size_t hop) {
    if (hop == kTurn) engine.aim(there);
  });
  const auto latency = static_cast<std::size_t>(engine.latency_samples());
  // Until the turn the first place; and once the trunk has forgotten the old conditions (62 frames
  // reach far, but fade), it is nearer to the second than the places are to each other.
  for (std::size_t i = 0; i < kTurn * kHop; ++i) ASSERT_EQ(moving[i], at_first[i]) << i;
  double to_last = 0.0;
  double apart = 0.0;
  for (std::size_t i = kTurn * kHop + latency; i < kSamples; ++i) {
    to_last += std::pow(moving[i] - at_last[i], 2);
    apart += std::pow(at_first[i] - at_last[i], 2);
  }
  EXPECT_LT(to_last, 0.05 * apart);
}

TEST(Gtf, AStreamOnItsOwnSettlesOnTheStatisticsOfASteadySound) {
  Gtf engine = engine_that_looks(small());
  const std::vector<float> source = noise(2 * 4 * kSamples, 0.1, 2);
  std::vector<float> window(source.size());
  engine.synthesize(source, window);
  const GtfStatistics whole = engine.statistics();
  engine.start();
  static_cast<void>(streamed(engine, source, [](std::size_t) {}));
  // A second of noise: its level is known to 1 in sqrt(32000).
  EXPECT_NEAR(engine.statistics().level, whole.level, 0.02 * whole.level);
  for (std::size_t i = 0; i < whole.summary.size(); ++i) {
    EXPECT_NEAR(engine.statistics().summary[i], whole.summary[i], 0.15) << i;
  }
}

TEST(Gtf, HasAnAnswerToSilence) {
  Gtf engine = engine_that_looks(small());
  std::vector<float> output(2 * kSamples);
  engine.synthesize(std::vector<float>(2 * kSamples), output);
  for (const float sample : output) ASSERT_TRUE(std::abs(sample) < 1e-3F);
}

}  // namespace
}  // namespace earpoint
