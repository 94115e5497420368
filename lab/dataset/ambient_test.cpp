#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/fft.h>
#include <earpoint/dataset/ambient.h>

namespace earpoint {
namespace {

constexpr int kRateHz = 16000;

double mean_product(std::span<const float> a, std::span<const float> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += double{a[i]} * b[i];
  return sum / static_cast<double>(a.size());
}

Waveform noise(double seconds, double level_db, std::uint64_t seed) {
  Waveform sound(2, std::lround(seconds * kRateHz), kRateHz);
  RandomStream random(seed);
  add_room_noise(sound, level_db, random);
  return sound;
}

/// A speaker's hum in both sounds, half as strong at the target.
PairSample hum() {
  PairSample sample;
  sample.source = Waveform(2, kRateHz, kRateHz);
  sample.target = Waveform(2, kRateHz, kRateHz);
  for (std::ptrdiff_t i = 0; i < kRateHz; ++i) {
    const auto x = static_cast<float>(std::sin(2.0 * kPi * 500.0 * static_cast<double>(i) / 16e3));
    for (int ear = 0; ear < 2; ++ear) {
      sample.source.channel(ear)[i] = 0.2F * x;
      sample.target.channel(ear)[i] = 0.1F * x;
    }
  }
  return sample;
}

bool equal(const Waveform& a, const Waveform& b) {
  return std::ranges::equal(a.planar(), b.planar());
}

TEST(RoomNoise, HasTheLevelThatIsAskedFor) {
  for (const double level_db : {-20.0, -40.0}) {
    const Waveform sound = noise(60.0, level_db, 1);
    for (int ear = 0; ear < 2; ++ear) {
      const auto samples = sound.channel(ear);
      // Noise of 20 Hz has some 40 independent values a second: the power of 2400 has a standard
      // error of 3 %, and four times that is 0.5 dB.
      EXPECT_NEAR(10.0 * std::log10(mean_product(samples, samples)), level_db, 0.5);
    }
  }
}

TEST(RoomNoise, ACornerAtHalfTheRateMakesItNearlyWhite) {
  Waveform sound(2, std::ptrdiff_t{60} * kRateHz, kRateHz);
  RandomStream random(1);
  add_room_noise(sound, -20.0, random, 0, 0.5 * kRateHz);
  const auto samples = sound.channel(0);
  // The power of a million independent values has a standard error of 0.15 %.
  EXPECT_NEAR(mean_product(samples, samples), 0.01, 1e-4);
  // One pole at exp(-pi): each sample keeps 4 % of the one before.
  const double next = mean_product(samples.first(samples.size() - 1), samples.subspan(1)) / 0.01;
  EXPECT_NEAR(next, std::exp(-kPi), 0.005);
}

TEST(RoomNoise, FallsBySixDecibelAnOctave) {
  const Waveform sound = noise(64.0, -20.0, 2);
  RealFft<double> fft(static_cast<int>(sound.samples()));
  const std::vector<double> samples(sound.channel(0).begin(), sound.channel(0).end());
  std::vector<std::complex<double>> spectrum(static_cast<std::size_t>(fft.bins()));
  fft.forward(samples, spectrum);
  const auto density_db = [&](double low_hz, double high_hz) {
    const double bins_per_hz = static_cast<double>(sound.samples()) / kRateHz;
    double sum = 0.0;
    const auto first = static_cast<std::size_t>(low_hz * bins_per_hz);
    const auto last = static_cast<std::size_t>(high_hz * bins_per_hz);
    for (std::size_t bin = first; bin < last; ++bin) sum += std::norm(spectrum[bin]);
    return 10.0 * std::log10(sum / static_cast<double>(last - first));
  };
  // 6400 bins or more per band: a standard error of 1.3 %, 0.05 dB. The octave of 1 / (20^2 + f^2)
  // from 100 Hz on falls by 0.1 dB less than one far above 20 Hz.
  EXPECT_NEAR(density_db(200.0, 400.0) - density_db(100.0, 200.0), -6.02, 0.25);
  EXPECT_NEAR(density_db(800.0, 1600.0) - density_db(400.0, 800.0), -6.02, 0.25);
  // Flat below 20 Hz: 0.5 dB less in the upper band, and 0.35 dB of standard error for the ratio of
  // two bands with some 300 bins each.
  EXPECT_NEAR(density_db(5.0, 10.0) - density_db(0.5, 5.0), 0.0, 1.0);
}

TEST(RoomNoise, IsAnotherInEveryEarAndTheSameForTheSameSeed) {
  const Waveform sound = noise(60.0, -20.0, 3);
  const double correlation = mean_product(sound.channel(0), sound.channel(1)) / 0.01;
  // 2400 independent values: standard deviation 0.02.
  EXPECT_NEAR(correlation, 0.0, 0.08);
  EXPECT_TRUE(equal(sound, noise(60.0, -20.0, 3)));
  EXPECT_FALSE(equal(sound, noise(60.0, -20.0, 4)));
}

TEST(Ambient, IsAddedToBothSoundsIndependently) {
  const PairSample quiet = hum();
  PairSample noisy = quiet;
  add_ambient(noisy, -30.0, 7);
  std::vector<float> at_source;
  std::vector<float> at_target;
  for (std::ptrdiff_t i = 0; i < kRateHz; ++i) {
    at_source.push_back(noisy.source.channel(1)[i] - quiet.source.channel(1)[i]);
    at_target.push_back(noisy.target.channel(1)[i] - quiet.target.channel(1)[i]);
  }
  // Some 40 independent values: standard errors of 1 dB in level and 0.16 in correlation, each four
  // times.
  EXPECT_NEAR(10.0 * std::log10(mean_product(at_source, at_source)), -30.0, 4.0);
  EXPECT_NEAR(10.0 * std::log10(mean_product(at_target, at_target)), -30.0, 4.0);
  EXPECT_NEAR(mean_product(at_source, at_target) / 1e-3, 0.0, 0.6);
  PairSample again = quiet;
  add_ambient(again, -30.0, 7);
  EXPECT_TRUE(equal(again.source, noisy.source));
  EXPECT_TRUE(equal(again.target, noisy.target));
}

TEST(Ambient, SeparationKeepsSpeechAndBothPartsAddUp) {
  const PairSample quiet = hum();
  PairSample sample = quiet;
  RandomStream random(5);
  add_room_noise(sample.source, -20.0, random);
  const Waveform heard = sample.source;
  separate_source(sample);
  ASSERT_TRUE(sample.ambient.has_value());
  EXPECT_TRUE(equal(sample.target, quiet.target));
  double left = 0.0;
  for (std::size_t i = 0; i < heard.planar().size(); ++i) {
    // To float's rounding.
    EXPECT_NEAR(sample.source.planar()[i] + sample.ambient->planar()[i], heard.planar()[i], 1e-6F);
    left += std::pow(double{sample.source.planar()[i]} - quiet.source.planar()[i], 2);
  }
  // A sixth of the power of 1 / (20^2 + f^2) lies above 80 Hz: -28 dB, and a little less behind the
  // filter's slope.
  const double left_db = 10.0 * std::log10(left / static_cast<double>(heard.planar().size()));
  EXPECT_NEAR(left_db, -28.5, 1.5);
}

}  // namespace
}  // namespace earpoint
