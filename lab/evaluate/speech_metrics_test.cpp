#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/evaluate/speech_metrics.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

using Sound = std::vector<float>;

// The sounds of testdata/estoi_reference.py, sample by sample.

Sound noise(std::size_t samples) {
  Sound sound(samples);
  std::uint32_t state = 7;
  for (float& x : sound) {
    state = 1664525U * state + 1013904223U;
    x = static_cast<float>(state / 2147483648.0 - 1.0);
  }
  return sound;
}

Sound syllables(int rate_hz) {
  Sound sound(static_cast<std::size_t>(3 * rate_hz));
  for (std::size_t i = 0; i < sound.size(); ++i) {
    const double t = static_cast<double>(i) / rate_hz;
    const double phase = 2.0 * kPi * 160.0 * t + 6.0 * std::sin(2.0 * kPi * 0.8 * t);
    const double loud =
        std::max(0.0, std::sin(2.0 * kPi * 2.2 * t) + 0.4 * std::sin(2.0 * kPi * 3.7 * t));
    double sum = 0.0;
    for (int h = 1; h <= 25; ++h) {
      const double vowel = 1.0 + 0.9 * std::sin(0.6 * h + 2.0 * kPi * 1.3 * t);
      sum += vowel * std::sin(h * phase) / h;
    }
    sound[i] = static_cast<float>(0.1 * loud * sum);
  }
  return sound;
}

Sound with_noise(const Sound& clean, float size) {
  Sound sound = noise(clean.size());
  for (std::size_t i = 0; i < sound.size(); ++i) sound[i] = clean[i] + size * sound[i];
  return sound;
}

Sound with_echoes(const Sound& clean, int rate_hz) {
  Sound sound = clean;
  for (const auto& [delay_s, gain] : {std::pair{0.05, 0.7F}, {0.13, 0.5F}, {0.21, 0.4F}}) {
    const auto delay = static_cast<std::size_t>(delay_s * rate_hz);
    for (std::size_t i = delay; i < sound.size(); ++i) sound[i] += gain * clean[i - delay];
  }
  return sound;
}

double estoi(const Sound& clean, const Sound& other, int rate_hz) {
  return Estoi().measure(clean, other, rate_hz).value();
}

TEST(Estoi, GivesTheNumbersOfAnotherImplementation) {
  // 10 kHz needs no resampling: only float against double and the rounding of a band's edge differ.
  // testdata/estoi_reference.py prints the numbers.
  const Sound clean = syllables(10000);
  EXPECT_NEAR(estoi(clean, with_noise(clean, 0.02F), 10000), 0.92870, 1e-3);
  EXPECT_NEAR(estoi(clean, with_noise(clean, 0.1F), 10000), 0.48334, 1e-3);
  EXPECT_NEAR(estoi(clean, with_noise(clean, 0.5F), 10000), 0.10456, 1e-3);
  EXPECT_NEAR(estoi(clean, with_echoes(clean, 10000), 10000), 0.79020, 1e-3);
  // At 16 kHz the two resamplers' filters differ near 5 kHz, in the last of 15 bands.
  const Sound wide = syllables(16000);
  EXPECT_NEAR(estoi(wide, with_noise(wide, 0.02F), 16000), 0.96224, 0.01);
  EXPECT_NEAR(estoi(wide, with_noise(wide, 0.1F), 16000), 0.58336, 0.01);
  EXPECT_NEAR(estoi(wide, with_noise(wide, 0.5F), 16000), 0.13584, 0.01);
  EXPECT_NEAR(estoi(wide, with_echoes(wide, 16000), 16000), 0.79020, 0.01);
}

TEST(Estoi, IsOneForTheReferenceAtAnyLevel) {
  const Sound clean = syllables(16000);
  Sound quiet = clean;
  for (float& x : quiet) x *= 0.01F;
  // Normalised correlation of equal spectra: rounding.
  EXPECT_NEAR(estoi(clean, clean, 16000), 1.0, 1e-6);
  EXPECT_NEAR(estoi(clean, quiet, 16000), 1.0, 1e-4);
}

TEST(Estoi, LeavesOutPausesOfTheReference) {
  const Sound clean = syllables(16000);
  Sound other = clean;
  const Sound hiss = noise(clean.size());
  for (std::size_t i = 0; i < other.size(); ++i) {
    // Only where the reference is silent for two frame lengths on either side.
    const std::size_t first = i > 820 ? i - 820 : 0;
    const std::size_t last = std::min(i + 820, clean.size());
    const bool silent = std::all_of(clean.begin() + static_cast<std::ptrdiff_t>(first),
                                    clean.begin() + static_cast<std::ptrdiff_t>(last),
                                    [](float x) { return x == 0.0F; });
    if (silent) other[i] = 0.1F * hiss[i];
  }
  ASSERT_NE(other, clean);
  // The resampling filter for 10 kHz spreads some of the noise into the first and last frames of
  // the speech.
  EXPECT_NEAR(estoi(clean, other, 16000), 1.0, 1e-3);
}

TEST(Estoi, IsNotThereForLessThanThirtyFramesOfSpeech) {
  const Sound clean = syllables(16000);
  // 30 frames of 256 with a hop of 128 at 10 kHz are 3968 samples: 6349 samples at 16 kHz.
  EXPECT_FALSE(Estoi().measure(std::span(clean).first(6000), std::span(clean).first(6000), 16000));
  const Sound silence(16000);
  EXPECT_FALSE(Estoi().measure(silence, silence, 16000).has_value());
  EXPECT_FALSE(Estoi().measure({}, {}, 16000).has_value());
}

TEST(SiSdr, IsTheRatioOfWhatIsOrthogonal) {
  // Orthogonal: a sine and a cosine over whole periods; the power of the second is 10 dB less.
  Sound reference(16000);
  Sound estimate(16000);
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const double angle = 2.0 * kPi * 100.0 * static_cast<double>(i) / 16000.0;
    reference[i] = static_cast<float>(std::sin(angle));
    estimate[i] =
        static_cast<float>(-3.0 * std::sin(angle) + 3.0 * std::sqrt(0.1) * std::cos(angle));
  }
  // Float samples: 1e-7 of the amplitude.
  EXPECT_NEAR(si_sdr_db(reference, estimate).value(), 10.0, 1e-4);
}

TEST(SiSdr, DoesNotDependOnLevelOrSign) {
  const Sound clean = syllables(16000);
  const Sound noisy = with_noise(clean, 0.05F);
  Sound other = noisy;
  for (float& x : other) x *= -7.0F;
  // Seven times a float is rounded again, by 6e-8 of a sample: less than 1e-5 dB for noise of a
  // tenth.
  EXPECT_NEAR(si_sdr_db(clean, noisy).value(), si_sdr_db(clean, other).value(), 1e-4);
}

TEST(SiSdr, HasALargestValueAndNoneOfSilence) {
  const Sound clean = syllables(16000);
  const Sound silence(clean.size());
  EXPECT_EQ(si_sdr_db(clean, clean), kLargestSiSdrDb);
  EXPECT_FALSE(si_sdr_db(silence, clean).has_value());
  EXPECT_FALSE(si_sdr_db(clean, silence).has_value());
}

}  // namespace
}  // namespace earpoint
