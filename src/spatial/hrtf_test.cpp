#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/fft.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/hrtf.h>

namespace earpoint {
namespace {

constexpr int kRate = 44100;

const SofaFile& kemar_file() {
  static const SofaFile file = read_sofa(default_hrtf_path());
  return file;
}

const HrtfSet& kemar() {
  static const HrtfSet set(kemar_file(), kRate, HrtfEqualization::none);
  return set;
}

Vector3 direction(double azimuth_deg, double elevation_deg = 0.0) {
  return cartesian_from_spherical(
      {radians_from_degrees(azimuth_deg), radians_from_degrees(elevation_deg), 1.0});
}

double energy_db(std::span<const float> taps) {
  double sum = 0.0;
  for (const float tap : taps) sum += static_cast<double>(tap) * tap;
  return 10.0 * std::log10(sum);
}

// Levels of the third-octave bands from 200 Hz to 16 kHz (or to 0.45 of the rate), in dB.
std::vector<double> third_octaves_db(std::span<const float> taps, int rate_hz = kRate) {
  constexpr int kSize = 8192;
  RealFft<float> fft(kSize);
  std::vector<float> padded(kSize, 0.0F);
  std::ranges::copy(taps, padded.begin());
  std::vector<std::complex<float>> spectrum(fft.bins());
  fft.forward(padded, spectrum);
  std::vector<double> levels;
  for (int band = -7; band <= 12; ++band) {
    const double centre_hz = 1000.0 * std::exp2(band / 3.0);
    if (centre_hz > 0.45 * rate_hz) break;
    const int low = static_cast<int>(std::ceil(centre_hz * std::exp2(-1.0 / 6) * kSize / rate_hz));
    const int high = static_cast<int>(centre_hz * std::exp2(1.0 / 6) * kSize / rate_hz);
    double power = 0.0;
    for (int bin = low; bin <= high; ++bin) power += std::norm(spectrum[bin]);
    levels.push_back(10.0 * std::log10(power / (high - low + 1)));
  }
  return levels;
}

double rms_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

double itd_us(const Hrir& hrir, int rate_hz = kRate) {
  return (hrir.onset_samples[1] - hrir.onset_samples[0]) * 1e6 / rate_hz;
}

// Woodworth's ray around a rigid sphere of 8.75 cm, far source on the horizon.
double woodworth_us(double azimuth_deg) {
  const double lateral = std::asin(std::sin(radians_from_degrees(azimuth_deg)));
  return 0.0875 / 343.2 * (lateral + std::sin(lateral)) * 1e6;
}

TEST(HrtfSet, UnequalizedAtItsOwnRateIsWhatTheFileHolds) {
  ASSERT_EQ(kemar().size(), 710U);
  for (std::size_t i = 0; i < kemar().size(); i += 37) {
    for (int ear = 0; ear < 2; ++ear) {
      EXPECT_TRUE(std::ranges::equal(kemar().response(i, ear), kemar_file().response(i, ear)));
    }
  }
}

TEST(HrtfSet, LeftIsLouderAndEarlierAtTheLeftEar) {
  for (const double elevation : {-30.0, 0.0, 30.0}) {
    for (const double azimuth : {30.0, 60.0, 90.0, 120.0, 150.0}) {
      const Hrir left = kemar().interpolated(direction(azimuth, elevation));
      EXPECT_GT(energy_db(left.taps[0]), energy_db(left.taps[1]) + 3.0) << azimuth;
      EXPECT_LT(left.onset_samples[0], left.onset_samples[1] - 4.0) << azimuth;
      const Hrir right = kemar().interpolated(direction(-azimuth, elevation));
      EXPECT_LT(energy_db(right.taps[0]), energy_db(right.taps[1]) - 3.0) << azimuth;
      EXPECT_GT(right.onset_samples[0], right.onset_samples[1] + 4.0) << azimuth;
    }
  }
}

TEST(HrtfSet, ItdFollowsTheRayAroundASphere) {
  for (double azimuth = -180.0; azimuth <= 180.0; azimuth += 2.5) {
    // KEMAR is no sphere: its neck, the place of its ears and the 10 % threshold make up to 45 us.
    EXPECT_NEAR(itd_us(kemar().interpolated(direction(azimuth))), woodworth_us(azimuth), 45.0)
        << azimuth;
  }
  // 656 us is the sphere's largest, within the 45 us above.
  EXPECT_NEAR(itd_us(kemar().interpolated(direction(90.0))), 656.0, 40.0);
}

TEST(HrtfSet, SoundPassesTheHeadsMiddleBetweenTheEars) {
  // At +90 degrees the near ear leads the middle by a/c, 11.2 samples, and the far one lags by
  // (pi/2) a/c, 17.7; KEMAR is within 2 samples of that.
  const Hrir left = kemar().interpolated(direction(90.0));
  EXPECT_NEAR(kemar().centre_delay_samples() - left.onset_samples[0], 11.2, 2.0);
  EXPECT_NEAR(left.onset_samples[1] - kemar().centre_delay_samples(), 17.7, 2.0);
}

TEST(HrtfSet, NearestIsByAngleAndWrapsRound) {
  EXPECT_NEAR(norm(kemar().direction(kemar().nearest(direction(358.0, 1.0))) - direction(0.0)), 0.0,
              1e-6);
  EXPECT_NEAR(
      norm(kemar().direction(kemar().nearest(direction(77.0, 88.0))) - direction(0.0, 90.0)), 0.0,
      1e-6);
}

TEST(HrtfSet, InterpolatingAtAMeasurementGivesIt) {
  for (std::size_t i = 0; i < kemar().size(); i += 7) {
    const Hrir found = kemar().interpolated(kemar().direction(i) * 2.0);
    for (int ear = 0; ear < 2; ++ear) {
      const auto expected = kemar().response(i, ear);
      double error = 0.0;
      double energy = 0.0;
      for (int tap = 0; tap < kemar().taps(); ++tap) {
        error += std::pow(found.taps[ear][tap] - expected[tap], 2.0);
        energy += std::pow(expected[tap], 2.0);
      }
      // Only the imaginary part at Nyquist is lost, where KEMAR is nearly silent.
      EXPECT_LT(10.0 * std::log10(error / energy), -60.0) << i;
      EXPECT_NEAR(found.onset_samples[ear], kemar().onset_samples(i, ear), 1e-4);
    }
  }
}

// The set without every other azimuth on the horizon (10 degrees apart are left).
SofaFile without_odd_azimuths(const SofaFile& file, std::vector<std::size_t>& left_out) {
  SofaFile thinned{file.sample_rate_hz, file.taps, {}, {}, {}};
  for (std::size_t i = 0; i < file.positions_m.size(); ++i) {
    const Spherical s = spherical_from_cartesian(file.positions_m[i]);
    const auto azimuth_deg = static_cast<int>(std::lround(degrees_from_radians(s.azimuth_rad)));
    if (std::abs(s.elevation_rad) < 0.01 && azimuth_deg % 10 != 0) {
      left_out.push_back(i);
      continue;
    }
    thinned.positions_m.push_back(file.positions_m[i]);
    thinned.delays_samples.push_back(file.delays_samples[i]);
    for (int ear = 0; ear < 2; ++ear) {
      const auto response = file.response(i, ear);
      thinned.responses.insert(thinned.responses.end(), response.begin(), response.end());
    }
  }
  return thinned;
}

TEST(HrtfSet, LeftOutMeasurementsAreMetBetweenTheirNeighbours) {
  std::vector<std::size_t> left_out;
  const HrtfSet thinned(without_odd_azimuths(kemar_file(), left_out), kRate,
                        HrtfEqualization::none);
  ASSERT_EQ(left_out.size(), 36U);
  double near_ear = 0.0;
  double far_ear = 0.0;
  double averaged = 0.0;
  double onset = 0.0;
  for (const std::size_t i : left_out) {
    const Vector3 there = kemar().direction(i);
    const Hrir found = thinned.interpolated(there);
    const double azimuth_deg = degrees_from_radians(spherical_from_cartesian(there).azimuth_rad);
    const std::size_t before = kemar().nearest(direction(azimuth_deg - 5.0));
    const std::size_t after = kemar().nearest(direction(azimuth_deg + 5.0));
    for (int ear = 0; ear < 2; ++ear) {
      const std::vector<double> expected = third_octaves_db(kemar().response(i, ear));
      const double error = rms_difference(third_octaves_db(found.taps[ear]), expected);
      ((there.y > 0.0) == (ear == 0) ? near_ear : far_ear) += error / 36.0;
      std::vector<float> average(kemar().taps());
      std::ranges::transform(kemar().response(before, ear), kemar().response(after, ear),
                             average.begin(), [](float a, float b) { return 0.5F * (a + b); });
      averaged += rms_difference(third_octaves_db(average), expected) / 72.0;
      onset = std::max(onset, std::abs(found.onset_samples[ear] - kemar().onset_samples(i, ear)));
    }
  }
  RecordProperty("near_ear_db", std::to_string(near_ear));
  RecordProperty("far_ear_db", std::to_string(far_ear));
  RecordProperty("plain_average_db", std::to_string(averaged));
  RecordProperty("onset_samples", std::to_string(onset));
  // Limits from the measured errors. Plain averaging makes a comb filter and is several times
  // worse.
  EXPECT_LT(near_ear, 0.25);
  EXPECT_LT(far_ear, 1.0);
  EXPECT_GT(averaged, 3.0 * (near_ear + far_ear) / 2.0);
  EXPECT_LT(onset, 0.7);
}

TEST(HrtfSet, SpectrumAndItdChangeSmoothlyAlongTheHorizon) {
  std::vector<double> last;
  double last_itd = 0.0;
  for (double azimuth = 0.0; azimuth <= 90.0; azimuth += 1.0) {
    const Hrir hrir = kemar().interpolated(direction(azimuth));
    const std::vector<double> levels = third_octaves_db(hrir.taps[0]);
    if (azimuth > 0.0) {
      for (std::size_t band = 0; band < levels.size(); ++band) {
        // The near ear's spectrum changes by less than 1 dB per degree in every third octave.
        EXPECT_NEAR(levels[band], last[band], 1.0) << azimuth << " degrees, band " << band;
      }
      // 7.8 us per degree at the front, -2 near 90; a jump to the next measurement would be 40.
      EXPECT_NEAR(itd_us(hrir) - last_itd, 4.0, 8.0) << azimuth;
    }
    last = levels;
    last_itd = itd_us(hrir);
  }
}

TEST(HrtfSet, FrontBackAndHeightSoundDifferent) {
  const auto front = third_octaves_db(kemar().interpolated(direction(0.0)).taps[0]);
  const auto back = third_octaves_db(kemar().interpolated(direction(180.0)).taps[0]);
  const auto above = third_octaves_db(kemar().interpolated(direction(0.0, 60.0)).taps[0]);
  // The pinna changes spectra by several decibels; equal spectra would mean that a direction is
  // ignored.
  EXPECT_GT(rms_difference(front, back), 3.0);
  EXPECT_GT(rms_difference(front, above), 3.0);
  EXPECT_GT(rms_difference(back, above), 3.0);
}

TEST(HrtfSet, LeftAndRightMirrorEachOther) {
  // Its makers have mirrored one ear, so interpolated responses must be mirror images too. Spectra
  // are kept as logarithm and phase in single precision.
  RandomStream random(3);
  for (int i = 0; i < 200; ++i) {
    const double azimuth = random.uniform(-180.0, 180.0);
    const double elevation = random.uniform(-80.0, 90.0);
    const Hrir one = kemar().interpolated(direction(azimuth, elevation));
    const Hrir other = kemar().interpolated(direction(-azimuth, elevation));
    for (int tap = 0; tap < kemar().taps(); ++tap) {
      ASSERT_NEAR(one.taps[0][tap], other.taps[1][tap], 2e-5) << azimuth << " " << elevation;
    }
  }
}

TEST(HrtfSet, BelowTheLowestRingTheStandInIsSmooth) {
  // KEMAR has no directions below -40 degrees: straight down is the average of the lowest ring, the
  // same at both ears. 1 us is a twentieth of a sample.
  const Hrir down = kemar().interpolated(direction(0.0, -90.0));
  EXPECT_NEAR(itd_us(down), 0.0, 1.0);
  for (const double azimuth : {0.0, 90.0, 180.0, 270.0}) {
    const Hrir near = kemar().interpolated(direction(azimuth, -89.5));
    // Half a degree of the 50 to the ring: 1 % of a difference of up to 20 dB.
    EXPECT_NEAR(energy_db(near.taps[0]), energy_db(down.taps[0]), 0.2) << azimuth;
  }
}

class HrtfRates : public testing::TestWithParam<int> {};

TEST_P(HrtfRates, ResamplingKeepsGainsAndDelays) {
  const int rate_hz = GetParam();
  const HrtfSet set(kemar_file(), rate_hz, HrtfEqualization::none);
  for (const double azimuth : {0.0, 45.0, 90.0, 180.0, 300.0}) {
    const std::size_t i = set.nearest(direction(azimuth));
    for (int ear = 0; ear < 2; ++ear) {
      const auto expected = third_octaves_db(kemar().response(i, ear));
      const auto found = third_octaves_db(set.response(i, ear), rate_hz);
      for (std::size_t band = 0; band < found.size(); ++band) {
        // Bands are sums over different bins: 0.1 dB; near the far ear's notches 0.3.
        EXPECT_NEAR(found[band], expected[band], 0.3) << azimuth << " band " << band;
      }
      // Delays relative to the middle of the head are the same.
      EXPECT_NEAR((set.onset_samples(i, ear) - set.centre_delay_samples()) / rate_hz,
                  (kemar().onset_samples(i, ear) - kemar().centre_delay_samples()) / kRate, 1e-7);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(HrtfSet, HrtfRates, testing::Values(16000, 32000, 48000));

TEST(HrtfSet, ResampledResponsesLineUpWithTheOriginal) {
  // Twice the rate: every other sample is the original's, except for the low-pass.
  const HrtfSet doubled(kemar_file(), 2 * kRate, HrtfEqualization::none);
  const double shift = doubled.onset_samples(0, 0) - 2.0 * kemar().onset_samples(0, 0);
  ASSERT_NEAR(shift, std::round(shift), 1e-6);
  const auto fine = doubled.response(0, 0);
  const auto coarse = kemar().response(0, 0);
  double error = 0.0;
  double energy = 0.0;
  for (int tap = 0; tap < kemar().taps(); ++tap) {
    // Half the value per tap, as twice as many taps have the same gain.
    error += std::pow(2.0 * fine[2 * tap + std::lround(shift)] - coarse[tap], 2.0);
    energy += std::pow(coarse[tap], 2.0);
  }
  // KEMAR is at least 20 dB down where the low-pass falls (above 20.3 kHz).
  EXPECT_LT(10.0 * std::log10(error / energy), -25.0);
}

TEST(HrtfSet, DiffuseFieldEqualizationLevelsTheSphere) {
  const HrtfSet set(kemar_file(), kRate);
  // Average the power over evenly spread directions.
  constexpr int kSize = 8192;
  RealFft<float> fft(kSize);
  std::vector<float> padded(kSize);
  std::vector<std::complex<float>> spectrum(fft.bins());
  std::vector<double> power(fft.bins(), 0.0);
  constexpr int kDirections = 300;
  for (int k = 0; k < kDirections; ++k) {
    const double z = 1.0 - (2.0 * k + 1.0) / kDirections;
    const double turn = 2.399963 * k;
    const double radius = std::sqrt(1.0 - z * z);
    // Measured directions, as interpolated log magnitudes are a little lower.
    const auto taps =
        set.response(set.nearest({radius * std::cos(turn), radius * std::sin(turn), z}), 0);
    std::ranges::fill(padded, 0.0F);
    std::ranges::copy(taps, padded.begin());
    fft.forward(padded, spectrum);
    for (int bin = 0; bin < fft.bins(); ++bin) power[bin] += std::norm(spectrum[bin]) / kDirections;
  }
  for (double centre_hz = 125.0; centre_hz < 15000.0; centre_hz *= std::exp2(1.0 / 3.0)) {
    const int low = static_cast<int>(std::ceil(centre_hz * std::exp2(-1.0 / 6) * kSize / kRate));
    const int high = static_cast<int>(centre_hz * std::exp2(1.0 / 6) * kSize / kRate);
    double sum = 0.0;
    for (int bin = low; bin <= high; ++bin) sum += power[bin];
    // Smoothing over third octaves and 300 directions instead of all: 1 dB.
    EXPECT_NEAR(10.0 * std::log10(sum / (high - low + 1)), 0.0, 1.0) << centre_hz;
  }
}

TEST(HrtfSet, EqualizationKeepsDifferencesBetweenDirectionsAndEars) {
  const HrtfSet set(kemar_file(), kRate);
  const std::size_t front = set.nearest(direction(0.0));
  const std::size_t side = set.nearest(direction(60.0));
  const auto difference = [&](const HrtfSet& of) {
    std::vector<double> result = third_octaves_db(of.response(side, 1));
    const std::vector<double> reference = third_octaves_db(of.response(front, 0));
    for (std::size_t band = 0; band < result.size(); ++band) result[band] -= reference[band];
    return result;
  };
  // One filter for all: differences stay, except for the smoothing within third octaves.
  EXPECT_LT(rms_difference(difference(set), difference(kemar())), 0.5);
}

TEST(HrtfSet, TakesASetWithDelaysAndOneRingOnly) {
  const std::filesystem::path folder =
      std::filesystem::path(EARPOINT_SOURCE_DIR) / "src/spatial/testdata";
  const SofaFile plain = read_sofa(folder / "sphere.sofa");
  const SofaFile delays = read_sofa(folder / "sphere_cartesian_swapped_delays.sofa");
  const HrtfSet a(plain, 48000, HrtfEqualization::none);
  const HrtfSet b(delays, 48000, HrtfEqualization::none);
  for (const double azimuth : {0.0, 20.0, 90.0, 200.0}) {
    const Hrir one = a.interpolated(direction(azimuth, 10.0));
    const Hrir other = b.interpolated(direction(azimuth, 10.0));
    for (int ear = 0; ear < 2; ++ear) {
      for (int tap = 0; tap < a.taps(); ++tap) {
        // Pure impulses with fractional delays ring at Nyquist, and the two sets have different
        // lengths: up to 1.3e-3 of the peak.
        EXPECT_NEAR(one.taps[ear][tap], other.taps[ear][tap], 2e-3) << azimuth << " " << tap;
      }
    }
  }
}

TEST(HrtfSet, UsesTheFarthestSourcesOnly) {
  SofaFile file =
      read_sofa(std::filesystem::path(EARPOINT_SOURCE_DIR) / "src/spatial/testdata/sphere.sofa");
  const HrtfSet far(file, 48000, HrtfEqualization::none);
  // The same directions again, nearer and louder.
  for (std::size_t i = 0; i < 8; ++i) {
    file.positions_m.push_back(file.positions_m[i] * 0.5);
    file.delays_samples.push_back(file.delays_samples[i]);
  }
  const std::vector<float> responses = file.responses;
  for (const float value : responses) file.responses.push_back(2.0F * value);
  const HrtfSet both(file, 48000, HrtfEqualization::none);
  EXPECT_EQ(both.size(), 8U);
  EXPECT_TRUE(std::ranges::equal(both.response(3, 0), far.response(3, 0)));
}

TEST(HrtfSet, RefusesTooFewDirections) {
  SofaFile few{48000, 4, {}, {}, {}};
  EXPECT_THROW(HrtfSet(few, 48000), InputError);
  few.positions_m = {{1, 0, 0}, {0, 1, 0}};
  few.responses.assign(2 * 2 * 4, 1.0F);
  few.delays_samples.resize(2);
  EXPECT_THROW(HrtfSet(few, 48000), InputError);
}

}  // namespace
}  // namespace earpoint
