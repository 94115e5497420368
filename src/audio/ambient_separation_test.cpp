#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/ambient_separation.h>
#include <earpoint/core/random.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr int kRateHz = 16000;
constexpr std::array kTracking{AmbientSeparation::subtract, AmbientSeparation::mmse};

Waveform white_noise(double seconds, double size, std::uint64_t seed) {
  Waveform sound(2, std::lround(seconds * kRateHz), kRateHz);
  RandomStream random(seed);
  for (float& sample : sound.planar()) sample = static_cast<float>(size * random.normal());
  return sound;
}

/// Syllables of a voice of 150 Hz: harmonics that fall by 6 dB an octave, 0.4 s each, with
/// pauses as long; the right ear half as loud.
Waveform syllables(double seconds) {
  Waveform sound(2, std::lround(seconds * kRateHz), kRateHz);
  for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
    const double t = static_cast<double>(i) / kRateHz;
    const double loud = std::max(0.0, std::sin(2.0 * kPi * 1.25 * t));
    double sum = 0.0;
    for (int h = 1; h <= 20; ++h) sum += std::sin(2.0 * kPi * 150.0 * h * t + h * h) / h;
    sound.channel(0)[i] = static_cast<float>(0.2 * loud * sum);
    sound.channel(1)[i] = 0.5F * sound.channel(0)[i];
  }
  return sound;
}

Waveform sum(const Waveform& a, const Waveform& b) {
  Waveform result = a;
  for (std::size_t i = 0; i < a.planar().size(); ++i) result.planar()[i] += b.planar()[i];
  return result;
}

double power(std::span<const float> sound) {
  double total = 0.0;
  for (const float x : sound) total += double{x} * x;
  return total / static_cast<double>(sound.size());
}

/// Power of the difference between `sound` and `clean`, in dB re the power of `clean`.
double error_db(const Waveform& clean, const Waveform& sound) {
  Waveform difference = sound;
  for (std::size_t i = 0; i < clean.planar().size(); ++i) {
    difference.planar()[i] -= clean.planar()[i];
  }
  return 10.0 * std::log10(power(difference.planar()) / power(clean.planar()));
}

/// The result of a stream in blocks of all sizes.
Waveform streamed(const Waveform& sound, NoiseSuppressor& suppressor) {
  Waveform result(sound.channels(), sound.samples(), kRateHz);
  std::ptrdiff_t written = 0;
  RandomStream random(9);
  for (std::ptrdiff_t start = 0; start < sound.samples();) {
    const auto count = std::min<std::ptrdiff_t>(1 + static_cast<std::ptrdiff_t>(random.index(3000)),
                                                sound.samples() - start);
    Waveform block(sound.channels(), count, kRateHz);
    for (int c = 0; c < sound.channels(); ++c) {
      std::copy_n(sound.channel(c).begin() + start, count, block.channel(c).begin());
    }
    start += count;
    const Waveform done = suppressor.process(block, start == sound.samples());
    for (int c = 0; c < sound.channels(); ++c) {
      std::ranges::copy(done.channel(c), result.channel(c).begin() + written);
    }
    written += done.samples();
    // After the first second the output is late by a frame at most.
    if (start > kRateHz) {
      EXPECT_GT(written, start - 512);
    }
  }
  EXPECT_EQ(written, sound.samples());
  return result;
}

TEST(AmbientSeparation, IsKnownByName) {
  for (const std::string_view name : ambient_separation_names()) {
    EXPECT_EQ(name_of(ambient_separation_named(name).value()), name);
  }
  EXPECT_FALSE(ambient_separation_named("wiener").has_value());
}

TEST(NoiseSuppressor, GivesTheSameInBlocksAsOfAWholeSound) {
  const Waveform sound = sum(syllables(2.7), white_noise(2.7, 0.02, 1));
  for (const AmbientSeparation kind : kTracking) {
    NoiseSuppressor suppressor(kind, 2, kRateHz, 80.0);
    const Waveform whole = suppress_noise(sound, kind, 80.0);
    EXPECT_TRUE(std::ranges::equal(streamed(sound, suppressor).planar(), whole.planar()));
  }
}

TEST(NoiseSuppressor, TakesSoundsOfAnyLengthAndRate) {
  for (const std::ptrdiff_t samples : {0, 1, 100, 600, 16001}) {
    for (const int rate : {16000, 44100, 48000}) {
      const Waveform sound(2, samples, rate);
      for (const AmbientSeparation kind : kTracking) {
        const Waveform primary = suppress_noise(sound, kind, 80.0);
        EXPECT_EQ(primary.samples(), samples);
        EXPECT_EQ(primary.sample_rate_hz(), rate);
        EXPECT_TRUE(std::ranges::all_of(primary.planar(), [](float x) { return x == 0.0F; }));
      }
    }
  }
}

TEST(NoiseSuppressor, LetsSpeechWithoutNoisePass) {
  const Waveform speech = syllables(3.0);
  for (const AmbientSeparation kind : kTracking) {
    // In a pause of 0.4 s the smoothed power falls by 48 dB (0.8 a frame); the noise estimate is at
    // most 1.5 times that, 46 dB below the speech. Where syllables begin and end they are weaker.
    EXPECT_LT(error_db(speech, suppress_noise(speech, kind, 0.0)), -30.0);
  }
}

TEST(NoiseSuppressor, KeepsTheDifferencesBetweenTheEars) {
  const Waveform speech = syllables(3.0);
  Waveform sound = sum(speech, white_noise(3.0, 0.01, 2));
  for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
    sound.channel(1)[i] = 0.5F * sound.channel(0)[i];
  }
  for (const AmbientSeparation kind : kTracking) {
    const Waveform primary = suppress_noise(sound, kind, 80.0);
    for (std::ptrdiff_t i = 0; i < primary.samples(); ++i) {
      // Both ears go through the same gains: float rounding of values up to 1.
      ASSERT_NEAR(primary.channel(1)[i], 0.5F * primary.channel(0)[i], 1e-6);
    }
  }
}

TEST(NoiseSuppressor, RemovesAllThatIsBelowTheCutoff) {
  Waveform hum(2, 2 * kRateHz, kRateHz);
  for (std::ptrdiff_t i = 0; i < hum.samples(); ++i) {
    hum.channel(0)[i] = hum.channel(1)[i] =
        static_cast<float>(std::sin(2.0 * kPi * 31.25 * static_cast<double>(i) / kRateHz));
  }
  for (const AmbientSeparation kind : kTracking) {
    const Waveform primary = suppress_noise(hum, kind, 80.0);
    // In the middle, away from the tone's beginning and end. A square-root Hann window passes a
    // tone two bins off at -24 dB in amplitude, and the rest of so steady a tone counts as noise.
    EXPECT_LT(10.0 * std::log10(power(primary.channel(0).subspan(8000, 16000)) / 0.5), -30.0);
  }
}

/// E[G^2 gamma] of noise alone by the rule of spectral subtraction, gamma being the mean of two
/// exponentially distributed powers: density 4 g exp(-2 g).
double left_by_subtraction() {
  double left = 0.0;
  constexpr double kStep = 1e-4;
  for (double g = kStep / 2; g < 20.0; g += kStep) {
    const double gain = std::max(1.0 - 1.0 / g, 0.01);
    left += gain * g * 4.0 * g * std::exp(-2.0 * g) * kStep;
  }
  return 10.0 * std::log10(left);
}

TEST(NoiseSuppressor, SubtractionLeavesOfNoiseWhatItsRuleSays) {
  const Waveform noise = white_noise(6.0, 0.05, 3);
  const Waveform primary = suppress_noise(noise, AmbientSeparation::subtract, 0.0);
  const double left_db = 10.0 * std::log10(power(primary.channel(0).subspan(2 * kRateHz)) /
                                           power(noise.channel(0).subspan(2 * kRateHz)));
  // Frames overlap by three quarters, and their spectra after different gains are not those of one
  // sound: joining the frames loses up to 2 dB. The noise is estimated up to 0.6 dB too low, which
  // leaves a dB more.
  EXPECT_NEAR(left_db, left_by_subtraction(), 2.0);
}

TEST(NoiseSuppressor, MmseLeavesOfNoiseWhatItsLowestPriorAllows) {
  const Waveform noise = white_noise(6.0, 0.05, 4);
  const Waveform primary = suppress_noise(noise, AmbientSeparation::mmse, 0.0);
  const double left_db = 10.0 * std::log10(power(primary.channel(0).subspan(2 * kRateHz)) /
                                           power(noise.channel(0).subspan(2 * kRateHz)));
  // With xi at its floor v is small and E1(v) = -C - ln v, so that G^2 gamma = xi e^-C (C Euler's
  // constant): -25 dB - 2.5 dB, whatever gamma is. The decision-directed term adds 0.02 (gamma - 1)
  // where gamma > 1, on average 0.02 * 2 e^-2 = -22.7 dB: together -20.7 - 2.5 dB. Joining the
  // frames loses up to 2 dB, the error of the noise estimate adds up to 1 dB.
  EXPECT_NEAR(left_db, -23.2, 3.0);
}

TEST(NoiseSuppressor, BringsSpeechNearerToWhatItWasWithoutNoise) {
  const Waveform speech = syllables(5.0);
  const Waveform noise = white_noise(5.0, 0.1, 5);
  const Waveform sound = sum(speech, noise);
  const double before_db = error_db(speech, sound);
  // The voice's 20 harmonics fill a third of the 8 kHz (their lines 3 bins of 5 up to 3 kHz) in
  // half of the time: an ideal mask would keep a fifth of the noise, 7 dB less. Half of that is
  // required.
  EXPECT_LT(error_db(speech, suppress_noise(sound, AmbientSeparation::subtract, 80.0)),
            before_db - 3.5);
  EXPECT_LT(error_db(speech, suppress_noise(sound, AmbientSeparation::mmse, 80.0)),
            before_db - 3.5);
}

TEST(NoiseSuppressor, FollowsNoiseThatRises) {
  Waveform noise = white_noise(6.0, 0.01, 6);
  for (int ear = 0; ear < 2; ++ear) {
    for (float& x : noise.channel(ear).subspan(3 * kRateHz)) x *= 10.0F;
  }
  for (const AmbientSeparation kind : kTracking) {
    const Waveform primary = suppress_noise(noise, kind, 0.0);
    const auto left_db = [&](double from_s, double to_s) {
      const auto first = static_cast<std::size_t>(from_s * kRateHz);
      const auto count = static_cast<std::size_t>((to_s - from_s) * kRateHz);
      return 10.0 * std::log10(power(primary.channel(0).subspan(first, count)) /
                               power(noise.channel(0).subspan(first, count)));
    };
    // Counts as speech at first, like any sound that begins, and as noise after 1.6 s.
    EXPECT_GT(left_db(3.1, 3.4), -3.0);
    EXPECT_NEAR(left_db(4.8, 6.0), left_db(1.5, 2.9), 1.5);
  }
}

}  // namespace
}  // namespace earpoint
