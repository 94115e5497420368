#include "late_field.h"

#include "gates/measurement.h"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 16000;
constexpr double kBin_s = 0.002;

// A decay of 60 dB in the given time, the same in all bands, from one sector.
EnergyHistogram decay(double time_s, int sector) {
  EnergyHistogram late(500, kBin_s);
  for (int bin = 0; bin < late.bins(); ++bin) {
    late.at(bin, sector) =
        all_bands(static_cast<float>(std::pow(10.0, -6.0 * bin * kBin_s / time_s)));
  }
  return late;
}

double total(const EnergyHistogram& late, int band) {
  double sum = 0.0;
  for (int bin = 0; bin < late.bins(); ++bin) {
    sum += static_cast<double>(late.bin_energy(bin)[band]);
  }
  return sum;
}

class LateFieldTest : public ::testing::Test {
 protected:
  ResponseShape shape_{.sample_rate_hz = kRate_hz, .samples = 16000, .fft_size = 18000};
  LateField field_{shape_, 1};

  std::vector<float> mono(const EnergyHistogram& late, std::uint64_t stream) {
    std::vector<float> signal(shape_.samples);
    field_.add_mono(late, {}, stream, signal);
    return signal;
  }
};

TEST_F(LateFieldTest, EnergyFollowsTheHistogramInEveryBand) {
  const EnergyHistogram late = decay(0.5, 3);
  for (int band = 1; band <= 6; ++band) {
    const double centre_hz = kOctaveBandCentresHz[band];
    double mean = 0.0;
    constexpr int kDraws = 8;
    for (int draw = 0; draw < kDraws; ++draw) {
      const std::vector<float> signal = mono(late, draw);
      mean += gates::energy(gates::band_of(signal, kRate_hz, centre_hz, 1.0)) / kDraws;
    }
    // What the same filter passes of an impulse of energy 1.
    std::vector<float> impulse(shape_.samples);
    impulse[8000] = 1.0F;
    const double passed = gates::energy(gates::band_of(impulse, kRate_hz, centre_hz, 1.0));
    // One draw varies by 0.7 dB at 125 Hz and less above; the mean by a third of that.
    EXPECT_NEAR(gates::decibels(mean / passed / total(late, band)), 0.0, 0.5) << centre_hz;
  }
}

TEST_F(LateFieldTest, DecayTimeIsThatOfTheHistogram) {
  const EnergyHistogram late = decay(0.5, 3);
  for (int band = 3; band <= 6; ++band) {
    const std::vector<double> octave =
        gates::band_of(mono(late, 5), kRate_hz, kOctaveBandCentresHz[band], 1.0);
    const double found_s = gates::decay_time_s(gates::backward_energy(octave), kRate_hz, -5, -35);
    // A single draw with corrected levels: a standard error of 2 % at 500 Hz, less above.
    EXPECT_NEAR(found_s, 0.5, 0.03) << band;
  }
}

TEST_F(LateFieldTest, StreamsAreDifferentNoise) {
  const EnergyHistogram late = decay(0.3, 0);
  const std::vector<float> a = mono(late, 1);
  const std::vector<float> b = mono(late, 2);
  EXPECT_EQ(a, mono(late, 1));
  const double energies = std::sqrt(std::inner_product(a.begin(), a.end(), a.begin(), 0.0) *
                                    std::inner_product(b.begin(), b.end(), b.begin(), 0.0));
  // Some 500 independent samples have most of the energy: a standard error of 0.045.
  EXPECT_NEAR(std::inner_product(a.begin(), a.end(), b.begin(), 0.0) / energies, 0.0, 0.15);
}

TEST_F(LateFieldTest, SilenceStaysSilent) {
  const std::vector<float> signal = mono(EnergyHistogram(500, kBin_s), 1);
  EXPECT_EQ(std::count(signal.begin(), signal.end(), 0.0F), std::ssize(signal));
}

TEST_F(LateFieldTest, SoundFromTheLeftIsLouderOnTheLeft) {
  const HrtfSet hrtf = HrtfSet::load(kRate_hz);
  const int left = sector_of(0.0F, 1.0F, 0.0F);
  std::vector<std::vector<float>> ears(2, std::vector<float>(shape_.samples));
  field_.add_binaural(decay(0.3, left), {}, hrtf, 1, ears);
  const auto energy = [](const std::vector<float>& ear) {
    return std::inner_product(ear.begin(), ear.end(), ear.begin(), 0.0);
  };
  EXPECT_GT(energy(ears[0]), 4.0 * energy(ears[1]));
  // With the head turned round the same sound comes from the right.
  std::vector<std::vector<float>> turned(2, std::vector<float>(shape_.samples));
  field_.add_binaural(decay(0.3, left), quaternion_from_euler({.yaw_rad = kPi}), hrtf, 1, turned);
  EXPECT_GT(energy(turned[1]), 4.0 * energy(turned[0]));
}

TEST_F(LateFieldTest, EarsInADiffuseFieldAreAlikeInLevelAndUnlikeInPhase) {
  EnergyHistogram late(500, kBin_s);
  for (int sector = 0; sector < kSectors; ++sector) late.add(decay(0.5, sector));
  const HrtfSet hrtf = HrtfSet::load(kRate_hz);
  // The mean of several draws, as a decay has few periods.
  constexpr int kDraws = 6;
  std::array<double, 3> coherence{};
  const std::array<double, 3> centres_hz = {250.0, 2000.0, 4000.0};
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<std::vector<float>> ears(2, std::vector<float>(shape_.samples));
    field_.add_binaural(late, {}, hrtf, draw, ears);
    for (std::size_t i = 0; i < centres_hz.size(); ++i) {
      const std::vector<double> a = gates::band_of(ears[0], kRate_hz, centres_hz[i], 1.0);
      const std::vector<double> b = gates::band_of(ears[1], kRate_hz, centres_hz[i], 1.0);
      const double both = std::sqrt(gates::energy(a) * gates::energy(b));
      // The octave at 250 Hz has some 13 independent values in such a decay (177 Hz times 72 ms): a
      // standard error of 1.2 dB; the others have less.
      EXPECT_NEAR(gates::decibels(gates::energy(a) / gates::energy(b)), 0.0, 3.0) << centres_hz[i];
      coherence[i] += std::inner_product(a.begin(), a.end(), b.begin(), 0.0) / both / kDraws;
    }
  }
  // Coherence of two free microphones 25 cm apart, to which a head of 18 cm is equivalent: sin(k d)
  // / (k d) is 0.8 at 250 Hz and within 0.1 of zero above 1 kHz; the mean has a standard error of
  // 0.1.
  EXPECT_GT(coherence[0], 0.5);
  EXPECT_LT(std::abs(coherence[1]), 0.3);
  EXPECT_LT(std::abs(coherence[2]), 0.3);
}

}  // namespace
}  // namespace earpoint
