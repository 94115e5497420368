#include "pulse_train.h"

#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr int kSize = 480;
constexpr int kRate_hz = 16000;

TEST(PulseTrain, SpectrumHasExactPhasesBetweenSamples) {
  const OctaveBank bank(kRate_hz, kSize);
  PulseTrain train(kSize);
  RandomStream random(4);
  std::vector<std::complex<double>> expected(kSize / 2 + 1);
  for (int i = 0; i < 5; ++i) {
    const double position = i == 0 ? 0.25 : random.uniform(0.0, 400.0);
    const auto gain = static_cast<float>(random.normal());
    train.add(position, all_bands(gain));
    for (int bin = 0; bin <= kSize / 2; ++bin) {
      expected[bin] +=
          static_cast<double>(gain) * std::polar(1.0, -2.0 * kPi * bin * position / kSize);
    }
  }
  std::vector<std::complex<float>> found(kSize / 2 + 1);
  train.add_spectrum(bank, found);
  for (int bin = 0; bin <= kSize / 2; ++bin) {
    // Five pulses of about one, in single precision.
    EXPECT_NEAR(std::abs(std::complex<double>(found[bin]) - expected[bin]), 0.0, 1e-5) << bin;
  }
}

TEST(PulseTrain, BandsKeepTheirOwnGain) {
  const OctaveBank bank(kRate_hz, kSize);
  PulseTrain train(kSize);
  BandArray gains{};
  gains[4] = 2.0F;  // 1 kHz: bin 30
  train.add(10.0, gains);
  std::vector<std::complex<float>> found(kSize / 2 + 1);
  train.add_spectrum(bank, found);
  EXPECT_NEAR(std::abs(found[30]), 2.0F, 1e-5F);
  EXPECT_NEAR(std::abs(found[60]), 0.0F, 1e-5F);

  train.clear();
  std::fill(found.begin(), found.end(), 0.0F);
  train.add_spectrum(bank, found);
  EXPECT_EQ(std::abs(found[30]), 0.0F);
}

}  // namespace
}  // namespace earpoint
