#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/iso3382.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
constexpr int kRateHz = 48000;

/// Noise that falls by 60 dB in `t60_s`, after the direct sound at sample 480.
Waveform decaying_noise(double t60_s, double seconds = 2.0) {
  RandomStream random(1);
  Waveform wave(1, static_cast<std::ptrdiff_t>(seconds * kRateHz), kRateHz);
  for (std::ptrdiff_t n = 480; n < wave.samples(); ++n) {
    const double fall = std::pow(10.0, -3.0 * static_cast<double>(n - 480) / kRateHz / t60_s);
    wave.channel(0)[n] = static_cast<float>(0.1 * fall * random.normal());
  }
  return wave;
}

TEST(IsoBands, OfADecayingToneHaveItsTimesAndEnergies) {
  constexpr double kT60 = 1.0;
  const double rate = 6.0 * std::log(10.0) / kT60;  // of the energy
  for (int octave = 0; octave < 6; ++octave) {
    const double centre_hz = 125.0 * std::exp2(octave);
    SCOPED_TRACE(centre_hz);
    Waveform wave(1, 2 * kRateHz, kRateHz);
    for (std::ptrdiff_t n = 480; n < wave.samples(); ++n) {
      const double t = static_cast<double>(n - 480) / kRateHz;
      wave.channel(0)[n] =
          static_cast<float>(0.5 * std::exp(-rate * t / 2.0) * std::cos(2.0 * kPi * centre_hz * t));
    }
    const IsoBand band = iso_bands(wave.channel(0), kRateHz).at(octave);
    // A band of B hertz tells times apart by about 1 / B, here 1.4 / centre; twice that of kT60.
    const double spread = 2.8 / centre_hz;
    EXPECT_NEAR(*band.t30_s, kT60, 1e-3);  // below -5 dB the decay is straight
    EXPECT_NEAR(*band.t20_s, kT60, 1e-3);
    EXPECT_NEAR(*band.edt_s, kT60, spread);
    EXPECT_NEAR(band.ts_s, 1.0 / rate, spread);
    EXPECT_NEAR(band.d50, 1.0 - std::exp(-0.05 * rate), spread);
    // The derivative of decibels: 4.34 / (d (1 - d)) with d near 0.5 and 0.67.
    EXPECT_NEAR(band.c50_db, 10.0 * std::log10(std::expm1(0.05 * rate)), 20.0 * spread);
    EXPECT_NEAR(band.c80_db, 10.0 * std::log10(std::expm1(0.08 * rate)), 20.0 * spread);
  }
}

TEST(IsoBands, AreThoseOfAnIndependentCalculation) {
  const fs::path folder = fs::path(EARPOINT_SOURCE_DIR) / "lab/evaluate/testdata/conventions";
  const Waveform response = read_sound(folder / "rir_reference.wav");
  const nlohmann::json expected =
      nlohmann::json::parse(read_text_file(folder / "released.json")).at("iso").at("bands");
  const std::vector<IsoBand> bands = iso_bands(response.channel(0), response.sample_rate_hz());
  ASSERT_EQ(bands.size(), expected.size());
  for (std::size_t i = 0; i < bands.size(); ++i) {
    // Both are in double precision and agree to 1e-12; filters may round differently elsewhere.
    const auto near = [&](double found, const char* name) {
      EXPECT_NEAR(found, expected[i].at(name).get<double>(), 1e-9) << i << " " << name;
    };
    near(bands[i].centre_hz, "centre_hz");
    near(bands[i].c50_db, "c50_db");
    near(bands[i].c80_db, "c80_db");
    near(bands[i].d50, "d50");
    near(1000.0 * bands[i].ts_s, "ts_ms");
  }
}

TEST(IsoMetrics, AreMeansOfTheMiddleOctaves) {
  const Waveform reference = decaying_noise(0.8);
  const Waveform estimate = decaying_noise(1.0);
  const IsoMetrics same = iso_metrics({reference, reference});
  EXPECT_EQ(*same.edt_error_percent + *same.t20_error_percent + *same.t30_error_percent, 0.0);
  EXPECT_EQ(same.c50_error_db + same.c80_error_db + same.d50_error + same.ts_error_ms, 0.0);
  const IsoMetrics found = iso_metrics({reference, estimate});
  // The two share their noise, so most of its randomness cancels.
  EXPECT_NEAR(*found.t30_error_percent, 25.0, 2.5);
  const auto middle = [](const std::vector<IsoBand>& bands) {
    return (bands[2].c80_db + bands[3].c80_db) / 2.0;
  };
  EXPECT_NEAR(found.c80_error_db, std::abs(middle(found.reference[0]) - middle(found.estimate[0])),
              1e-9);
}

TEST(IsoMetrics, ADecayThatIsTooShortHasNoTime) {
  Waveform noisy = decaying_noise(0.5, 1.0);
  RandomStream random(2);
  for (float& x : noisy.planar()) x += static_cast<float>(0.005 * random.normal());
  const IsoMetrics metrics = iso_metrics({noisy, noisy});
  EXPECT_FALSE(metrics.t30_error_percent.has_value());
  EXPECT_TRUE(metrics.edt_error_percent.has_value());
}

TEST(IsoMetrics, NeedTheMiddleOctaves) {
  Waveform slow(1, 4000, 2000);
  slow.channel(0)[0] = 1.0F;
  slow.channel(0)[500] = 0.1F;
  try {
    (void)iso_metrics({slow, slow});
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "impulse responses: their sample rate is too low for the octave at 1000 Hz");
  }
  const Waveform silence(1, 48000, kRateHz);
  EXPECT_THROW((void)iso_metrics({silence, silence}), InputError);
}

}  // namespace
}  // namespace earpoint
