#include "clap_times.h"

#include "clock_fit.h"

#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 16000;

/// A burst of noise from sample `at` on that decays within milliseconds.
void add_burst(Waveform& sound, int ear, std::ptrdiff_t at, float level) {
  RandomStream random(5);  // the same burst everywhere
  for (std::ptrdiff_t i = 0; i < 800; ++i) {
    const double value = i == 0 ? 2.5 : random.uniform(-2.0, 2.0);
    sound.channel(ear)[at + i] +=
        level * static_cast<float>(value * std::exp(-static_cast<double>(i) / 128.0));
  }
}

/// A second of faint noise.
Waveform quiet_room() {
  Waveform sound(2, kRate_hz, kRate_hz);
  RandomStream random(3);
  for (float& x : sound.planar()) x = static_cast<float>(0.002 * random.normal());
  return sound;
}

TEST(ClapTimes, AreThoseOfTheDirectSoundAtBothEarsThoughAReflectionIsLouder) {
  Waveform sound = quiet_room();
  add_burst(sound, 0, 8005, 0.2F);  // 5 samples later than the right ear
  add_burst(sound, 1, 8000, 0.3F);
  add_burst(sound, 0, 8090, 0.5F);  // from the other side
  add_burst(sound, 1, 8100, 0.4F);
  const auto found = clap_at_ears(sound, 0.502, 5.0 / kRate_hz);
  ASSERT_TRUE(found.has_value());
  // Exact to a sample, as the burst begins with its largest step.
  EXPECT_NEAR((*found)[0], 8005.0 / kRate_hz, 1.0 / kRate_hz);
  EXPECT_NEAR((*found)[1], 8000.0 / kRate_hz, 1.0 / kRate_hz);
}

TEST(ClapTimes, AreNotToldWhereOnlyAReflectionIsHeard) {
  Waveform sound = quiet_room();
  add_burst(sound, 0, 8090, 0.5F);
  add_burst(sound, 1, 8100, 0.4F);
  EXPECT_FALSE(clap_at_ears(sound, 0.502, 5.0 / kRate_hz).has_value());
}

TEST(ClapTimes, OfAClapperAtTheLeftAreFirstAtTheLeftEar) {
  // The camera looks along y; the clapper stands 2 m to its left, at 0.4 s.
  const Pose head{{1, 2, 1.5}, quaternion_from_euler({.yaw_rad = 0.5 * kPi})};
  const Vector3 clap_m{-1, 2, 1.5};
  constexpr double kEmitted_s = 0.4;
  const auto sample_of = [&](int ear) {
    return std::lround((kEmitted_s + travel_time_s(clap_m, head, ear)) * kRate_hz);
  };
  // The delay between the ears is up to 0.7 ms, 11 samples.
  ASSERT_GT(sample_of(1), sample_of(0) + 5);
  Waveform sound = quiet_room();
  for (const int ear : {0, 1}) add_burst(sound, ear, sample_of(ear), 0.3F);
  const auto found = clap_emitted_s(sound, kEmitted_s + 2.0 / 343.0, clap_m, head);
  ASSERT_TRUE(found.has_value());
  // To a sample, as each ear's burst begins at a whole one.
  EXPECT_NEAR(*found, kEmitted_s, 1.0 / kRate_hz);
  Waveform exchanged = quiet_room();
  for (const int ear : {0, 1}) add_burst(exchanged, ear, sample_of(1 - ear), 0.3F);
  EXPECT_FALSE(clap_emitted_s(exchanged, kEmitted_s + 2.0 / 343.0, clap_m, head).has_value());
}

}  // namespace
}  // namespace earpoint
