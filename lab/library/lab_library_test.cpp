#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/metrics.h>
#include <earpoint/trace.h>

namespace earpoint {
namespace {

TraceRequest request() {
  TraceRequest wanted;
  wanted.source = {{1.0, 2.0, 1.5}, {}};
  wanted.listener = {{4.0, 2.0, 1.5}, quaternion_from_euler({kPi, 0.0, 0.0})};
  wanted.microphone = TraceMicrophone::omni;
  wanted.sample_rate_hz = 16000;
  wanted.duration_s = 0.6;
  return wanted;
}

TEST(TraceScene, DirectSoundArrivesAfterDistanceOverSpeedOfSoundAtItsLevel) {
  // With fully absorbing walls only the direct sound is left.
  const TraceScene room = TraceScene::box({6, 4, 3}, 1.0);
  const Waveform response = room.response(request());
  ASSERT_EQ(response.channels(), 1);
  const auto samples = response.channel(0);
  const auto peak =
      std::ranges::max_element(samples, {}, [](float sample) { return std::abs(sample); });
  // 3 m at 343 to 344 m/s; a sample is 21 mm.
  EXPECT_NEAR(static_cast<double>(peak - samples.begin()) / 16000.0, 3.0 / 343.5, 1.0 / 16000.0);
  // A third of the amplitude at 1 m; air and the position between two samples take away less than a
  // quarter.
  EXPECT_NEAR(*peak, 1.0 / 3.0, 1.0 / 12.0);
}

TEST(TraceScene, ABoxReverberatesAsSabineSays) {
  const TraceScene room = TraceScene::box({6, 4, 3}, 0.3, 0.5);
  TraceRequest wanted = request();
  wanted.microphone = TraceMicrophone::ears;
  const Waveform response = room.response(wanted);
  ASSERT_EQ(response.channels(), 2);
  // Eyring: 0.161 V / (-S ln(1 - a)) = 0.30 s; a box that is no cube, and air, change it by less
  // than a quarter.
  for (int ear = 0; ear < 2; ++ear) {
    EXPECT_NEAR(measure_reverberation(response, ear).t60_s, 0.30, 0.075) << ear;
  }
  wanted.threads = 3;
  EXPECT_TRUE(std::ranges::equal(room.response(wanted).planar(), response.planar()));
}

TEST(TraceScene, PlacesOutsideAreRefused) {
  const TraceScene room = TraceScene::box({6, 4, 3}, 0.3);
  TraceRequest wanted = request();
  wanted.listener.position_m.x = 7.0;
  EXPECT_THROW((void)room.response(wanted), InputError);
  wanted.listener = wanted.source;
  EXPECT_THROW((void)room.response(wanted), InputError);
  EXPECT_THROW((void)TraceScene::open("/missing.glb"), InputError);
}

TEST(CompareSounds, IsZeroForTheSameSoundAndGrowsWithNoise) {
  Waveform sound(2, 16000, 16000);
  RandomStream random(2);
  for (float& sample : sound.planar()) sample = static_cast<float>(0.1 * random.normal());
  const SoundDifference none = compare_sounds(sound, sound);
  EXPECT_EQ(none.mag, 0.0);
  EXPECT_EQ(none.l2, 0.0);
  EXPECT_EQ(none.delay_samples, 0.0);
  EXPECT_EQ(none.si_sdr_db, 100.0);
  EXPECT_NEAR(none.estoi.value(), 1.0, 1e-6);  // rounding of float sums
  Waveform noisy = sound;
  for (float& sample : noisy.planar()) sample += static_cast<float>(0.1 * random.normal());
  const SoundDifference some = compare_sounds(sound, noisy);
  EXPECT_GT(some.mag, 0.1);
  // Noise of the sound's own power: 0 dB, over 16000 samples within a quarter of one.
  EXPECT_NEAR(some.si_sdr_db.value(), 0.0, 0.25);
  EXPECT_LT(some.estoi.value(), 0.9);
  EXPECT_THROW((void)compare_sounds(sound, Waveform(2, 100, 16000)), InputError);
}

}  // namespace
}  // namespace earpoint
