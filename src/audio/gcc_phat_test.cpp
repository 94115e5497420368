#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/fft.h>
#include <earpoint/audio/gcc_phat.h>
#include <earpoint/core/random.h>

namespace earpoint {
namespace {

std::vector<float> noise(std::ptrdiff_t samples, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> signal(samples);
  for (float& x : signal) x = static_cast<float>(random.normal());
  return signal;
}

/// The definition, at every lag: one inverse transform of 16 n.
double delay_by_definition(const std::vector<float>& signal, const std::vector<float>& reference) {
  const auto n = static_cast<int>(signal.size() + reference.size());
  RealFft<double> fft(n);
  std::vector<double> a(n);
  std::vector<double> b(n);
  std::ranges::copy(signal, a.begin());
  std::ranges::copy(reference, b.begin());
  std::vector<std::complex<double>> cross(fft.bins());
  std::vector<std::complex<double>> other(fft.bins());
  fft.forward(a, cross);
  fft.forward(b, other);
  for (int k = 0; k < fft.bins(); ++k) {
    cross[k] *= std::conj(other[k]);
    cross[k] /= std::abs(cross[k]);
  }
  RealFft<double> fine(16 * n);
  cross.resize(fine.bins());
  std::vector<double> correlation(fine.size());
  fine.inverse(cross, correlation);
  int best = 0;
  double peak = -1.0;
  for (int lag = -8 * n; lag <= 8 * n; ++lag) {
    const double value = std::abs(correlation[lag < 0 ? lag + 16 * n : lag]);
    if (value > peak) {
      peak = value;
      best = lag;
    }
  }
  return best / 16.0;
}

TEST(GccPhat, FindsTheSameLagAsASearchOfEveryLag) {
  for (const auto& [length, other] :
       {std::pair{2, 2}, {7, 7}, {100, 100}, {101, 57}, {1, 64}, {640, 640}, {997, 1000}}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const std::vector<float> signal = noise(length, seed);
      // Independent noise has many peaks of similar height, shifted noise only one.
      const std::vector<float> stranger = noise(other, seed + 100);
      EXPECT_EQ(gcc_phat_delay_samples(signal, stranger), delay_by_definition(signal, stranger))
          << length << " and " << other << ", seed " << seed;
      std::vector<float> shifted = noise(length, seed + 200);
      for (int i = 3; i < length; ++i) shifted[i] = -0.7F * signal[i - 3] + 0.5F * shifted[i];
      EXPECT_EQ(gcc_phat_delay_samples(shifted, signal), delay_by_definition(shifted, signal))
          << length << " shifted, seed " << seed;
    }
  }
}

TEST(GccPhat, FractionalDelayIsFoundToTheSixteenth) {
  // A band-limited pulse train, delayed in closed form.
  const auto pulse = [](double delay) {
    std::vector<float> signal(2000);
    RandomStream random(3);
    for (int k = 0; k < 400; ++k) {
      const double frequency = random.uniform(0.01, 0.49);
      const double phase = random.uniform(0.0, 6.28);
      for (int i = 0; i < 2000; ++i) {
        const double window = std::exp(-std::pow((i - delay - 1000) / 300, 2));
        signal[i] +=
            static_cast<float>(window * std::cos(6.283185307 * frequency * (i - delay) + phase));
      }
    }
    return signal;
  };
  for (const double delay : {0.0, 0.0625, -0.3125, 7.5, -40.9375, 200.25}) {
    EXPECT_EQ(gcc_phat_delay_samples(pulse(delay), pulse(0.0)), delay);
  }
}

TEST(GccPhat, OneObjectServesManyPairs) {
  GccPhat estimator(500, 300);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const std::vector<float> signal = noise(500, seed);
    const std::vector<float> reference = noise(300, seed + 50);
    EXPECT_EQ(estimator.delay_samples(signal, reference),
              gcc_phat_delay_samples(signal, reference));
  }
}

TEST(GccPhat, ResultIsClamped) {
  std::vector<float> late(1000);
  const std::vector<float> early = noise(1000, 8);
  for (int i = 200; i < 1000; ++i) late[i] = early[i - 200];
  EXPECT_EQ(gcc_phat_delay_samples(late, early), 200.0);
  EXPECT_EQ(gcc_phat_delay_samples(late, early, 50.0), 50.0);
  EXPECT_EQ(gcc_phat_delay_samples(early, late, 50.0), -50.0);
}

TEST(GccPhat, SilenceGivesTheMostNegativeLag) {
  EXPECT_EQ(gcc_phat_delay_samples(std::vector<float>(100), noise(100, 1)), -100.0);
  EXPECT_EQ(gcc_phat_delay_samples(std::vector<float>(100), noise(100, 1), 50.0), -50.0);
}

TEST(GccPhat, WrongLengthsAreTheCallersBug) {
  const std::vector<float> signal = noise(10, 1);
  EXPECT_THROW((void)gcc_phat_delay_samples({}, signal), std::logic_error);
  GccPhat estimator(10, 11);
  EXPECT_THROW((void)estimator.delay_samples(signal, signal), std::logic_error);
}

}  // namespace
}  // namespace earpoint
