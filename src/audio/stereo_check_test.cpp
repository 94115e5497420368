#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/stereo_check.h>
#include <earpoint/core/random.h>

namespace earpoint {
namespace {

constexpr int kRate = 48000;
constexpr int kSamples = 3 * kRate;

/// Noise that falls by 6 dB per octave, in syllables, like the spectrum of speech.
std::vector<float> syllables(std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> sound(kSamples);
  double low = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    low += 0.1 * (random.uniform(-1.0, 1.0) - low);
    const double loud = std::max(0.0, std::sin(25.0 * i / kRate));
    sound[i] = static_cast<float>(loud * low);
  }
  return sound;
}

std::vector<float> noise(double level, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> sound(kSamples);
  for (float& sample : sound) sample = static_cast<float>(level * random.uniform(-1.0, 1.0));
  return sound;
}

std::vector<float> scaled(std::vector<float> sound, double gain) {
  for (float& sample : sound) sample *= static_cast<float>(gain);
  return sound;
}

std::vector<float> sum(std::vector<float> a, const std::vector<float>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

/// The sound at the ear away from the source: later and duller.
std::vector<float> shadowed(const std::vector<float>& sound, int delay) {
  std::vector<float> ear(sound.size());
  double low = 0.0;
  for (std::size_t i = 0; i + delay < sound.size(); ++i) {
    low += 0.2 * (sound[i] - low);
    ear[i + delay] = static_cast<float>(0.7 * low + 0.3 * sound[i]);
  }
  return ear;
}

std::string kind_of(const std::vector<float>& left, const std::vector<float>& right,
                    std::ptrdiff_t block = 5000) {
  StereoCheck check(kRate);
  for (std::ptrdiff_t start = 0; start < kSamples; start += block) {
    const std::ptrdiff_t count = std::min<std::ptrdiff_t>(block, kSamples - start);
    Waveform wave(2, count, kRate);
    std::copy_n(left.begin() + start, count, wave.channel(0).begin());
    std::copy_n(right.begin() + start, count, wave.channel(1).begin());
    check.add(wave);
  }
  return std::string(name_of(check.kind()));
}

TEST(StereoCheck, SoundThatIsLaterAndDullerAtOneEarIsPlausible) {
  const std::vector<float> sound = syllables(1);
  for (const int delay : {5, 10, 20, 35}) {  // 0.1 to 0.7 ms: 10 to 90 degrees
    EXPECT_EQ(kind_of(sound, shadowed(sound, delay)), "plausible") << delay;
    EXPECT_EQ(kind_of(shadowed(sound, delay), sound), "plausible") << delay;
    // A source close to one ear is louder there by 10 dB, and still earlier.
    EXPECT_EQ(kind_of(sound, scaled(shadowed(sound, delay), 0.3)), "plausible") << delay;
  }
}

TEST(StereoCheck, TwoTalkersAndRoomsAndNoiseArePlausible) {
  const std::vector<float> one = syllables(1);
  const std::vector<float> two = syllables(2);
  EXPECT_EQ(kind_of(sum(one, shadowed(two, 25)), sum(shadowed(one, 25), two)), "plausible");
  EXPECT_EQ(kind_of(sum(one, noise(0.02, 3)), sum(one, noise(0.02, 4))), "plausible");
  EXPECT_EQ(kind_of(noise(0.1, 1), noise(0.1, 2)), "plausible");
  EXPECT_EQ(kind_of(noise(0.0, 1), noise(0.0, 2)), "plausible");
}

TEST(StereoCheck, PannedSoundIsTold) {
  const std::vector<float> sound = syllables(1);
  for (const double gain : {0.7, 0.5, 0.25, 2.0}) {
    EXPECT_EQ(kind_of(sound, scaled(sound, gain)), "panned") << gain;
    // With noise of its own in each channel, 30 dB below.
    EXPECT_EQ(kind_of(sum(sound, noise(0.002, 3)), sum(scaled(sound, gain), noise(0.002, 4))),
              "panned")
        << gain;
  }
}

TEST(StereoCheck, EqualSilentAndInvertedChannelsAreTold) {
  const std::vector<float> sound = syllables(1);
  EXPECT_EQ(kind_of(sound, sound), "dual_mono");
  EXPECT_EQ(kind_of(sound, noise(0.0, 1)), "one_channel");
  EXPECT_EQ(kind_of(noise(0.0003, 1), sound), "one_channel");
  EXPECT_EQ(kind_of(sound, scaled(sound, -1.0)), "inverted");
  EXPECT_EQ(kind_of(sum(sound, noise(0.002, 3)), sum(scaled(sound, -0.5), noise(0.002, 4))),
            "inverted");
  EXPECT_EQ(kind_of(sound, scaled(shadowed(sound, 20), -1.0)), "inverted");
}

TEST(StereoCheck, BlocksMakeNoDifference) {
  const std::vector<float> sound = syllables(1);
  for (const std::ptrdiff_t block : {1000, 48000, 144000}) {
    EXPECT_EQ(kind_of(sound, scaled(sound, 0.5), block), "panned");
  }
  // Less than one analysis block is classified, too.
  StereoCheck check(kRate);
  Waveform wave(2, kRate / 5, kRate);
  for (int c = 0; c < 2; ++c) {
    std::copy_n(sound.begin(), wave.samples(), wave.channel(c).begin());
  }
  check.add(wave);
  EXPECT_EQ(name_of(check.kind()), "dual_mono");
}

}  // namespace
}  // namespace earpoint
