#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/evaluate/decay_metrics.h>

namespace earpoint {
namespace {

/// An exponential decay per channel, `length_s` long.
Waveform decays(const std::vector<double>& t60_s, double length_s, int rate_hz = 16000) {
  Waveform wave(static_cast<int>(t60_s.size()), std::llround(length_s * rate_hz), rate_hz);
  for (int c = 0; c < wave.channels(); ++c) {
    for (std::ptrdiff_t n = 0; n < wave.samples(); ++n) {
      const double level = -3.0 * static_cast<double>(n) / rate_hz / t60_s[c];
      wave.channel(c)[n] = static_cast<float>((n % 2 == 0 ? 1.0 : -1.0) * std::pow(10.0, level));
    }
  }
  return wave;
}

double c50_of(double t60_s) {
  const double late = std::pow(10.0, -6.0 * 0.05 / t60_s);
  return 10.0 * std::log10((1.0 - late) / late);
}

TEST(CompareDecays, ErrorsAreMeansOverTheEars) {
  const Waveform reference = decays({0.4, 0.6}, 1.0);
  const Waveform estimate = decays({0.5, 0.5}, 1.0);
  const DecayComparison found = compare_decays(reference, "a.wav", estimate, "b.wav");
  EXPECT_EQ(found.range, DecayRange::t30);
  ASSERT_EQ(found.reference.size(), 2U);
  // Straight decays: every range gives the same time, up to the error of the estimate of the
  // missing tail.
  EXPECT_NEAR(found.reference[0].t60_s, 0.4, 1e-3);
  EXPECT_NEAR(found.reference[1].edt_s, 0.6, 1e-3);
  EXPECT_NEAR(found.estimate[1].c50_db, c50_of(0.5), 1e-2);
  EXPECT_NEAR(found.t60_error_s, 0.1, 1e-3);
  EXPECT_NEAR(found.t60_error_percent, (25.0 + 100.0 / 6.0) / 2, 0.2);
  EXPECT_NEAR(found.edt_error_s, 0.1, 1e-3);
  // A difference of two, each 1e-2 off at most.
  EXPECT_NEAR(found.c50_error_db, (c50_of(0.4) - c50_of(0.5) + c50_of(0.5) - c50_of(0.6)) / 2,
              2e-2);
}

TEST(CompareDecays, OneChannelAndOtherRatesAreFine) {
  const DecayComparison found =
      compare_decays(decays({0.5}, 0.8), "a.wav", decays({0.5}, 0.6, 48000), "b.wav");
  // The two lengths end at different levels, so that the estimates of the missing tails differ as
  // above.
  EXPECT_NEAR(found.t60_error_s, 0.0, 1e-3);
  EXPECT_NEAR(found.c50_error_db, 0.0, 1e-2);
}

TEST(CompareDecays, ShortResponsesAreReadFromT20OnBothSides) {
  // 30 dB long: enough for T20 only. The missing tail begins 5 dB below its range, so that its
  // estimate counts more than above.
  const DecayComparison found =
      compare_decays(decays({0.5, 0.5}, 1.0), "a.wav", decays({0.5, 0.5}, 0.25), "b.wav");
  EXPECT_EQ(found.range, DecayRange::t20);
  EXPECT_NEAR(found.t60_error_s, 0.0, 2e-3);
}

TEST(CompareDecays, BadResponsesAreNamedWithTheirChannel) {
  const auto message = [](const Waveform& a, const Waveform& b) -> std::string {
    try {
      (void)compare_decays(a, "a.wav", b, "b.wav");
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  const Waveform good = decays({0.5, 0.5}, 1.0);
  EXPECT_NE(message(good, decays({0.5}, 1.0)).find("b.wav: has 1 channels, a.wav has 2"),
            std::string::npos);
  Waveform silent = good;
  for (float& x : silent.channel(1)) x = 0.0F;
  EXPECT_NE(message(good, silent).find("b.wav: channel 1: impulse response: is silent"),
            std::string::npos)
      << message(good, silent);
  EXPECT_NE(message(decays({0.5, 0.5}, 0.1), good).find("a.wav: channel 0"), std::string::npos);
}

}  // namespace
}  // namespace earpoint
