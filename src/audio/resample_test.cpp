#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/resample.h>
#include <earpoint/core/random.h>

namespace earpoint {
namespace {

constexpr double kTurn = 6.283185307179586476925286766559;

Waveform tone(double frequency_hz, int rate_hz, std::ptrdiff_t samples) {
  Waveform wave(1, samples, rate_hz);
  for (std::ptrdiff_t i = 0; i < samples; ++i) {
    wave.channel(0)[i] =
        static_cast<float>(0.5 * std::cos(kTurn * frequency_hz * static_cast<double>(i) / rate_hz));
  }
  return wave;
}

/// Largest absolute sample, except at the edges, where the filter reaches past the ends of the
/// sound.
double peak_inside(const Waveform& wave, std::ptrdiff_t edge) {
  double peak = 0.0;
  for (std::ptrdiff_t i = edge; i < wave.samples() - edge; ++i) {
    peak = std::max(peak, std::abs(double{wave.channel(0)[i]}));
  }
  return peak;
}

TEST(Resample, ToneKeepsItsAmplitudeAndPhase) {
  for (const auto& [from, to] : {std::pair{48000, 16000},
                                 {44100, 16000},
                                 {16000, 48000},
                                 {16000, 44100},
                                 {8000, 16000},
                                 {22050, 16000}}) {
    for (const double frequency : {100.0, 1000.0, 3600.0}) {
      const Waveform out = resample(tone(frequency, from, from), to);
      const Waveform expected = tone(frequency, to, to);
      ASSERT_EQ(out.samples(), expected.samples());
      for (std::ptrdiff_t i = 1000; i + 1000 < out.samples(); ++i) {
        // Float samples of size 0.5 through a filter with -120 dB of error.
        ASSERT_NEAR(out.channel(0)[i], expected.channel(0)[i], 1e-6)
            << from << " to " << to << ", " << frequency << " Hz, sample " << i;
      }
    }
  }
}

TEST(Resample, WhatTheNewRateCannotHoldIsGone) {
  // 9 and 12 kHz would fold to 7 and 4 kHz; the converter promises -120 dB.
  for (const double frequency : {9000.0, 12000.0, 20000.0}) {
    EXPECT_LT(peak_inside(resample(tone(frequency, 48000, 48000), 16000), 1000), 0.5e-6);
  }
}

TEST(Resample, LengthIsRoundedAndEmptyStaysEmpty) {
  for (const int samples : {0, 1, 2, 3, 5, 100, 441, 1000}) {
    for (const auto& [from, to] : {std::pair{44100, 16000}, {16000, 44100}, {48000, 16000}}) {
      const Waveform out = resample(Waveform(2, samples, from), to);
      EXPECT_EQ(out.samples(), std::llround(static_cast<double>(samples) * to / from));
      EXPECT_EQ(out.channels(), 2);
      EXPECT_EQ(out.sample_rate_hz(), to);
    }
  }
}

TEST(StreamResampler, BlocksOfAnySizeGiveWhatOneBlockGives) {
  RandomStream random(5);
  Waveform wave(2, 20000, 44100);
  for (float& x : wave.planar()) x = static_cast<float>(random.uniform(-0.5, 0.5));
  for (const int to : {16000, 48000}) {
    const Waveform whole = resample(wave, to);
    StreamResampler stream(2, 44100, to);
    std::vector<float> left;
    std::vector<float> right;
    int blocks = 0;
    for (std::ptrdiff_t start = 0; start < wave.samples();) {
      // Every third block is empty, which must not count as the end.
      const std::ptrdiff_t samples = ++blocks % 3 == 0
                                         ? 0
                                         : static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(
                                               random.index(3000), wave.samples() - start));
      Waveform block(2, samples, 44100);
      for (int c = 0; c < 2; ++c) {
        std::ranges::copy(wave.channel(c).subspan(start, samples), block.channel(c).begin());
      }
      start += samples;
      const Waveform out = stream.process(block, start == wave.samples());
      left.insert(left.end(), out.channel(0).begin(), out.channel(0).end());
      right.insert(right.end(), out.channel(1).begin(), out.channel(1).end());
    }
    ASSERT_EQ(std::ssize(left), whole.samples());
    for (std::ptrdiff_t i = 0; i < whole.samples(); ++i) {
      // Float rounding; the converter works in blocks of its own.
      ASSERT_NEAR(left[i], whole.channel(0)[i], 1e-6F) << i;
      ASSERT_NEAR(right[i], whole.channel(1)[i], 1e-6F) << i;
    }
  }
}

TEST(ResampleSinc, ConstantStaysConstantToItsEdges) {
  Waveform wave(1, 3000, 44100);
  std::ranges::fill(wave.planar(), 0.25F);
  const Waveform out = resample_sinc(wave, 16000);
  EXPECT_EQ(out.samples(), 3000 * 160 / 441);
  for (const float x : out.planar()) EXPECT_FLOAT_EQ(x, 0.25F);
}

}  // namespace
}  // namespace earpoint
