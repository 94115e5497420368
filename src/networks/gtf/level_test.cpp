#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/gtf/level.h>

namespace earpoint {
namespace {

Pose ahead(double distance_m) { return {{distance_m, 0, 0}, {}}; }

Waveform noise() {
  Waveform sound(2, 1000, 16000);
  RandomStream random(1);
  for (float& sample : sound.planar()) sample = static_cast<float>(0.1 * random.normal());
  return sound;
}

/// Level after limit_level() of a copy of the source with `gain_db`, re the source.
double left_db(double gain_db, double expected_db, const LevelTolerance& tolerance,
               bool knows_place) {
  const Waveform source = noise();
  Waveform result = source;
  for (float& sample : result.planar()) {
    sample *= static_cast<float>(std::pow(10.0, gain_db / 20.0));
  }
  limit_level(source, std::pow(10.0, expected_db / 10.0), tolerance, knows_place, result);
  return 20.0 * std::log10(result.planar()[0] / source.planar()[0]);
}

TEST(GtfLevel, ToleratesLittleAtRestAndBeyondTheTrainedRange) {
  EXPECT_LE(gtf_level_tolerance(Pose{}, {}).louder_db, 0.5);
  EXPECT_LE(gtf_level_tolerance(Pose{}, {}).quieter_db, 0.5);
  EXPECT_GT(gtf_level_tolerance(ahead(3.0), {}).quieter_db, 9.0);
  EXPECT_LE(gtf_level_tolerance(ahead(10.0), {}).louder_db, 1.0);
  EXPECT_LE(gtf_level_tolerance(ahead(1e4), {}).quieter_db, 3.0);
}

TEST(GtfLevel, ToleranceIsContinuousInTheDistance) {
  LevelTolerance before = gtf_level_tolerance(Pose{}, {});
  for (double distance_m = 0.0; distance_m < 20.0; distance_m += 0.01) {
    const LevelTolerance now = gtf_level_tolerance(ahead(distance_m), {});
    // 4.5 dB per metre is the steepest.
    ASSERT_NEAR(now.louder_db, before.louder_db, 0.046) << distance_m;
    ASSERT_NEAR(now.quieter_db, before.quieter_db, 0.046) << distance_m;
    before = now;
  }
}

TEST(GtfLevel, AWalksToleranceIsTheMeanOfItsPlaces) {
  const std::vector<Pose> path{ahead(0.0), ahead(1.0), ahead(2.0), ahead(1.0)};
  EXPECT_NEAR(gtf_level_tolerance(path, {}).louder_db,
              gtf_level_tolerance(ahead(1.0), {}).louder_db, 1e-12);
}

TEST(GtfLevel, BringsALevelToTheEdgeOfWhatItMayBe) {
  const LevelTolerance tolerance{.louder_db = 2.0, .quieter_db = 4.0};
  // Float samples, one quotient of two of them.
  EXPECT_NEAR(left_db(1.0, 0.0, tolerance, false), 1.0, 1e-4);
  EXPECT_NEAR(left_db(6.0, 0.0, tolerance, false), 2.0, 1e-4);
  EXPECT_NEAR(left_db(-20.0, -3.0, tolerance, false), -7.0, 1e-4);
}

TEST(GtfLevel, OnlyAGivenPlaceOfTheSpeakerMakesItLouderBy12Decibels) {
  const LevelTolerance tolerance{.louder_db = 5.0, .quieter_db = 5.0};
  // Float samples, one quotient of two of them.
  EXPECT_NEAR(left_db(40.0, 20.0, tolerance, false), 12.0, 1e-4);
  EXPECT_NEAR(left_db(40.0, 20.0, tolerance, true), 20.0, 1e-4);
  EXPECT_NEAR(left_db(40.0, 9.0, tolerance, true), 12.0, 1e-4);
}

TEST(GtfLevel, LeavesSilenceSilent) {
  const Waveform source(2, 1000, 16000);
  Waveform result = noise();
  limit_level(source, 1.0, {5.0, 5.0}, false, result);
  for (const float sample : result.planar()) ASSERT_EQ(sample, 0.0F);
  result = noise();
  limit_loudness(source, result);
  for (const float sample : result.planar()) ASSERT_EQ(sample, 0.0F);
}

TEST(GtfLevel, EnhancedSpeechIsLouderThanTheRecordingBy12DecibelsAtMost) {
  const Waveform source = noise();
  for (const double gain_db : {-60.0, 0.0, 11.0, 13.0, 80.0}) {
    Waveform result = source;
    for (float& sample : result.planar()) {
      sample *= static_cast<float>(std::pow(10.0, gain_db / 20.0));
    }
    limit_loudness(source, result);
    // Float samples, one quotient of two of them.
    EXPECT_NEAR(20.0 * std::log10(result.planar()[0] / source.planar()[0]), std::min(gain_db, 12.0),
                1e-4);
  }
}

}  // namespace
}  // namespace earpoint
