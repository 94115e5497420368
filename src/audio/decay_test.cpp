#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/decay.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kRate = 16000.0;

/// Amplitude of a decay that loses 60 dB in `t60_s`.
double decay_amplitude(double time_s, double t60_s) {
  return std::pow(10.0, -3.0 * time_s / t60_s);
}

/// A decay without randomness: its curve is a straight line.
std::vector<float> smooth_decay(double t60_s, double length_s, std::ptrdiff_t delay = 0) {
  std::vector<float> response(delay + std::llround(length_s * kRate));
  for (std::ptrdiff_t i = delay; i < std::ssize(response); ++i) {
    const double sign = i % 2 == 0 ? 1.0 : -1.0;
    response[i] =
        static_cast<float>(sign * decay_amplitude(static_cast<double>(i - delay) / kRate, t60_s));
  }
  return response;
}

/// Gaussian noise that decays, as a diffuse room's response, over a floor of steady noise.
std::vector<float> diffuse_decay(double t60_s, double length_s, double noise_db,
                                 std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> response(std::llround(length_s * kRate));
  const double floor = std::pow(10.0, noise_db / 20.0);
  for (std::size_t i = 0; i < response.size(); ++i) {
    const double amplitude = decay_amplitude(static_cast<double>(i) / kRate, t60_s);
    response[i] = static_cast<float>(amplitude * random.normal() + floor * random.normal());
  }
  return response;
}

TEST(Decay, ExponentialGivesItsTimeWhateverTheRange) {
  for (const double t60_s : {0.1, 0.4, 1.0, 3.0}) {
    const std::vector<float> response = smooth_decay(t60_s, 1.2 * t60_s, 137);
    // The curve is a straight line up to float rounding and the estimate of the cut-off tail.
    EXPECT_NEAR(early_decay_time_s(response, kRate), t60_s, 1e-4 * t60_s);
    EXPECT_NEAR(reverberation_time_t20_s(response, kRate), t60_s, 1e-4 * t60_s);
    EXPECT_NEAR(reverberation_time_t30_s(response, kRate), t60_s, 1e-4 * t60_s);
  }
}

TEST(Decay, CutOffTailDoesNotBendTheCurve) {
  // The response ends at -40 dB. Without the energy of the missing tail, which is estimated, the
  // curve would bend down.
  const double t60_s = 0.5;
  const std::vector<float> response = smooth_decay(t60_s, t60_s * 40.0 / 60.0);
  EXPECT_NEAR(reverberation_time_t30_s(response, kRate), t60_s, 1e-3 * t60_s);
}

TEST(Decay, DiffuseFieldGivesItsTimeWithinItsStatisticalError) {
  for (const double t60_s : {0.3, 0.6, 1.2}) {
    for (const double noise_db : {-200.0, -70.0, -55.0, -50.0}) {
      double mean_t30 = 0.0;
      double mean_t20 = 0.0;
      const int count = 8;
      for (int seed = 0; seed < count; ++seed) {
        const std::vector<float> response = diffuse_decay(t60_s, 1.5 * t60_s + 0.3, noise_db, seed);
        const double t30 = reverberation_time_t30_s(response, kRate);
        // One response of a white band: about 1 % standard deviation at 0.3 s.
        EXPECT_NEAR(t30, t60_s, 0.05 * t60_s) << "noise " << noise_db << " seed " << seed;
        mean_t30 += t30 / count;
        mean_t20 += reverberation_time_t20_s(response, kRate) / count;
      }
      // The mean of eight would show a bias, e.g. from noise that was not cut off.
      EXPECT_NEAR(mean_t30, t60_s, 0.02 * t60_s) << "noise " << noise_db;
      EXPECT_NEAR(mean_t20, t60_s, 0.02 * t60_s) << "noise " << noise_db;
    }
  }
}

TEST(Decay, EarlyAndLateSlopesAreToldApart) {
  // A double slope: 0.2 s early, 1.0 s from -25 dB on.
  std::vector<float> response = smooth_decay(0.2, 1.5);
  const std::vector<float> late = smooth_decay(1.0, 1.5);
  for (std::size_t i = 0; i < response.size(); ++i) {
    response[i] = std::hypot(response[i], late[i] * 0.056F);
  }
  EXPECT_LT(early_decay_time_s(response, kRate), 0.25);
  EXPECT_GT(reverberation_time_t30_s(response, kRate), 0.5);
}

TEST(Decay, ClarityOfAnExponentialIsTheClosedForm) {
  for (const double t60_s : {0.2, 0.5, 2.0}) {
    const double late = std::pow(10.0, -6.0 * 0.05 / t60_s);
    const double expected = 10.0 * std::log10((1.0 - late) / late);
    // The split falls on a whole sample; the energy after the cut is estimated.
    EXPECT_NEAR(clarity_c50_db(smooth_decay(t60_s, 1.2 * t60_s, 50), kRate), expected, 2e-3);
  }
}

TEST(Decay, PropagationDelayDoesNotCount) {
  const std::vector<float> near = smooth_decay(0.5, 0.7);
  const std::vector<float> far = smooth_decay(0.5, 0.7, 1600);
  EXPECT_DOUBLE_EQ(early_decay_time_s(near, kRate), early_decay_time_s(far, kRate));
  EXPECT_DOUBLE_EQ(clarity_c50_db(near, kRate), clarity_c50_db(far, kRate));
}

TEST(Decay, ScaleDoesNotCount) {
  std::vector<float> response = diffuse_decay(0.4, 0.8, -60.0, 3);
  const double t30 = reverberation_time_t30_s(response, kRate);
  for (float& x : response) x *= 1.0F / 1024;
  EXPECT_DOUBLE_EQ(reverberation_time_t30_s(response, kRate), t30);
}

std::string message_of(const std::vector<float>& response, auto measure) {
  try {
    (void)measure(response, kRate);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Decay, SaysWhyThereIsNoValue) {
  const auto t30 = [](const auto& response, double rate) {
    return reverberation_time_t30_s(response, rate);
  };
  EXPECT_NE(message_of({}, t30).find("is silent"), std::string::npos);
  EXPECT_NE(message_of(std::vector<float>(100, 0.0F), t30).find("is silent"), std::string::npos);
  EXPECT_NE(message_of({1.0F, NAN}, t30).find("sample 1 is not a finite"), std::string::npos);
  EXPECT_NE(message_of({0.0F, 1.0F, 0.0F}, t30).find("T30 needs a decay to -35 dB"),
            std::string::npos);
  EXPECT_NE(message_of(diffuse_decay(0.5, 1.0, -25.0, 1), t30).find("before its noise"),
            std::string::npos);
  EXPECT_NE(message_of(smooth_decay(1.0, 0.3), t30).find("needs a decay to -35"),
            std::string::npos);
  EXPECT_NE(message_of({1.0F, 1e-4F, 1e-5F, 1e-6F, 1e-7F}, t30).find("within one sample"),
            std::string::npos);
  EXPECT_NE(message_of({1.0F}, [](const auto& response,
                                  double rate) { return clarity_c50_db(response, rate); })
                .find("C50 has no value"),
            std::string::npos);
}

TEST(Decay, SteadyNoiseHasNoReverberationTime) {
  RandomStream random(9);
  std::vector<float> noise(16000);
  for (float& x : noise) x = static_cast<float>(random.normal());
  EXPECT_NE(message_of(noise, [](const auto& response,
                                 double rate) { return reverberation_time_t20_s(response, rate); })
                .find("does not decay"),
            std::string::npos);
}

}  // namespace
}  // namespace earpoint
