#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/metrics.h>
#include <earpoint/weights/safetensors.h>
#include <earpoint/weights_testing/reference_folders.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
constexpr double kTurn = 6.283185307179586476925286766559;

/// Results of the released evaluation: a part in testdata, all where EARPOINT_ORACLE_DIR says.
std::vector<fs::path> folders() { return reference_folders("lab/evaluate/testdata", "D_signal"); }

/// Clip `index` of a tensor [clips][2][samples].
Waveform clip_of(const Tensor& tensor, std::int64_t index) {
  const auto samples = static_cast<std::ptrdiff_t>(tensor.shape[2]);
  Waveform wave(2, samples, kMetricRateHz);
  std::ranges::copy(tensor.as<float>().subspan(index * 2 * samples, 2 * samples),
                    wave.planar().begin());
  return wave;
}

Waveform noise(std::ptrdiff_t samples, std::uint64_t seed, int rate_hz = kMetricRateHz) {
  RandomStream random(seed);
  Waveform wave(2, samples, rate_hz);
  for (float& x : wave.planar()) x = static_cast<float>(0.1 * random.normal());
  return wave;
}

Waveform scaled(const Waveform& wave, float left, float right) {
  Waveform result = wave;
  for (float& x : result.channel(0)) x *= left;
  for (float& x : result.channel(1)) x *= right;
  return result;
}

TEST(BinauralMetrics, AreTheReleasedEvaluations) {
  for (const fs::path& folder : folders()) {
    const SafetensorsFile file = read_safetensors(folder / "metrics.safetensors");
    const auto values = nlohmann::json::parse(read_text_file(folder / "metrics.json"));
    MetricEvaluator evaluator;
    const std::int64_t pairs = file.tensors.at("pred").shape[0];
    ASSERT_EQ(values.at("per_pair").size(), static_cast<std::size_t>(pairs));
    for (std::int64_t pair = 0; pair < pairs; ++pair) {
      const BinauralMetrics found = evaluator.measure(clip_of(file.tensors.at("tgt"), pair),
                                                      clip_of(file.tensors.at("pred"), pair));
      const auto& expected = values.at("per_pair").at(pair);
      // The released values are sums in float.
      const auto expect_near = [&](double value, const nlohmann::json& reference) {
        EXPECT_NEAR(value, reference.get<double>(), 1e-5 * reference.get<double>()) << pair;
      };
      expect_near(found.mag, expected.at("mag_distance").at(0));
      expect_near(found.stft_distance, expected.at("stft_distance").at(0));
      expect_near(found.l2, expected.at("l2_distance").at(0));
      // A difference of two levels of up to 7 dB, which the released evaluation rounds to float.
      const double lre = expected.at("lr_ratio").at(0).get<double>();
      EXPECT_NEAR(found.lre_db.value(), lre, 1e-5 * lre + 2e-6) << pair;
      EXPECT_EQ(found.delay_samples, expected.at("delay").get<double>()) << pair;
    }
  }
}

TEST(BinauralMetrics, TreatSilenceAsTheReleasedEvaluationDoes) {
  for (const fs::path& folder : folders()) {
    SCOPED_TRACE(folder);
    const SafetensorsFile file = read_safetensors(folder / "metrics.safetensors");
    // The file in testdata is computed by testdata/silence_reference.py.
    const bool is_ours = fs::exists(folder / "silence.json");
    const auto edges =
        nlohmann::json::parse(read_text_file(folder / (is_ours ? "silence.json" : "metrics.json")))
            .at("edge");
    const Waveform reference = clip_of(file.tensors.at("tgt"), 0);
    const Waveform estimate = clip_of(file.tensors.at("pred"), 0);
    const Waveform silence(2, 16000, kMetricRateHz);
    const auto check = [&](const char* edge, const BinauralMetrics& found) {
      const auto& expected = edges.at(edge);
      for (const auto& [value, name] : {std::pair{found.mag, "mag_distance"},
                                        {found.stft_distance, "stft_distance"},
                                        {found.l2, "l2_distance"}}) {
        // The released code sums in single precision.
        const double known = expected.at(name).at(0).get<double>();
        EXPECT_NEAR(value, known, 1e-5 * known) << edge << " " << name;
      }
      EXPECT_EQ(found.delay_samples, expected.at("delay").get<double>()) << edge;
      // Values that are infinite there are missing here.
      const auto& lre = expected.at("lr_ratio").at(0);
      ASSERT_EQ(found.lre_db.has_value(), lre.is_number()) << edge;
      if (lre.is_number()) {
        EXPECT_NEAR(*found.lre_db, lre.get<double>(), 1e-5 * lre.get<double>()) << edge;
      }
    };
    check("silent_right_pred", binaural_metrics(reference, scaled(estimate, 1.0F, 0.0F)));
    check("silent_pred", binaural_metrics(reference, silence));
    check("silent_tgt", binaural_metrics(silence, estimate));
  }
}

TEST(BinauralMetrics, OfEqualSoundsAreZero) {
  const Waveform wave = noise(16000, 1);
  const BinauralMetrics metrics = binaural_metrics(wave, wave);
  EXPECT_EQ(metrics.mag, 0.0);
  EXPECT_EQ(metrics.lre_db, 0.0);
  EXPECT_EQ(metrics.stft_distance, 0.0);
  EXPECT_EQ(metrics.l2, 0.0);
  EXPECT_EQ(metrics.delay_samples, 0.0);
}

TEST(BinauralMetrics, LouderLeftEarIsTheLeftRightError) {
  const Waveform wave = noise(16000, 2);
  const double factor_db = 20.0 * std::log10(2.0);
  EXPECT_NEAR(binaural_metrics(wave, scaled(wave, 2.0F, 1.0F)).lre_db.value(), factor_db, 1e-9);
  // The 1e-5 in the denominator is far below the energy of 160.
  EXPECT_NEAR(binaural_metrics(wave, scaled(wave, 1.0F, 2.0F)).lre_db.value(), factor_db, 1e-6);
  EXPECT_NEAR(binaural_metrics(wave, scaled(wave, 2.0F, 2.0F)).lre_db.value(), 0.0, 1e-6);
}

TEST(BinauralMetrics, FollowTheScaleOfTheDifference) {
  const Waveform wave = noise(16000, 3);
  const Waveform silence(2, 16000, kMetricRateHz);
  const BinauralMetrics whole = binaural_metrics(wave, silence);
  const BinauralMetrics half = binaural_metrics(wave, scaled(wave, 0.5F, 0.5F));
  // Halves of floats are exact; the sums and roots of either are doubles.
  EXPECT_NEAR(half.mag, whole.mag / 2, 1e-7 * whole.mag);
  EXPECT_NEAR(half.stft_distance, whole.stft_distance / 2, 1e-7 * whole.stft_distance);
  EXPECT_NEAR(half.l2, whole.l2 / 4, 1e-7 * whole.l2);
}

TEST(BinauralMetrics, SilentLeftEarHasNoLeftRightErrorAndSilenceTheLargestDelay) {
  const Waveform wave = noise(16000, 4);
  const BinauralMetrics left = binaural_metrics(wave, scaled(wave, 0.0F, 1.0F));
  EXPECT_FALSE(left.lre_db.has_value());
  EXPECT_EQ(left.delay_samples, 25.0);
  const BinauralMetrics both = binaural_metrics(wave, scaled(wave, 0.0F, 0.0F));
  EXPECT_FALSE(both.lre_db.has_value());
  EXPECT_EQ(both.delay_samples, kMostDelaySamples);
  EXPECT_FALSE(binaural_metrics(scaled(wave, 0.0F, 1.0F), wave).lre_db.has_value());
  // A silent right ear has a ratio, because of the constant in its denominator.
  const BinauralMetrics right = binaural_metrics(wave, scaled(wave, 1.0F, 0.0F));
  EXPECT_TRUE(std::isfinite(right.lre_db.value()));
  EXPECT_EQ(right.delay_samples, 25.0);
  for (const BinauralMetrics& metrics : {left, both, right}) {
    EXPECT_TRUE(std::isfinite(metrics.mag + metrics.stft_distance + metrics.l2));
  }
}

TEST(BinauralMetrics, DelayIsFoundAndClamped) {
  const Waveform wave = noise(16000, 5);
  Waveform late(2, 16000, kMetricRateHz);
  std::copy_n(wave.channel(0).begin(), 15993, late.channel(0).begin() + 7);
  std::copy_n(wave.channel(1).begin(), 15900, late.channel(1).begin() + 100);
  EXPECT_EQ(binaural_metrics(wave, late).delay_samples, (7.0 + kMostDelaySamples) / 2);
}

TEST(BinauralMetrics, DelayOfMoreThanAMinuteIsTheMeanOfItsParts) {
  // Two parts of 45 s, delayed by 4 and 10 samples.
  const std::ptrdiff_t half = std::ptrdiff_t{45} * 4000;
  const Waveform wave = noise(2 * half, 6, 4000);
  Waveform late(2, 2 * half, 4000);
  for (int c = 0; c < 2; ++c) {
    std::copy_n(wave.channel(c).begin(), half - 4, late.channel(c).begin() + 4);
    std::copy_n(wave.channel(c).begin() + half, half - 10, late.channel(c).begin() + half + 10);
  }
  EXPECT_EQ(binaural_metrics(wave, late).delay_samples, 7.0);
}

std::string message_of(const auto& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(BinauralMetrics, WhatCannotBeComparedIsNamed) {
  const Waveform wave = noise(1000, 7);
  const auto message = [&](const Waveform& estimate) {
    return message_of([&] { (void)binaural_metrics(wave, estimate); });
  };
  EXPECT_EQ(message(noise(999, 7)),
            "estimate: has 999 samples, reference has 1000; cut them to one length");
  EXPECT_EQ(message(noise(1000, 7, 48000)),
            "estimate: has 48000 Hz, reference has 16000 Hz; resample one of them");
  EXPECT_EQ(message(Waveform(1, 1000, 16000)),
            "estimate: has 1 channel, a binaural sound has 2 (left, right)");
  EXPECT_EQ(message(Waveform(2, 0, 16000)), "estimate: holds no samples");
  Waveform broken = wave;
  broken.channel(1)[17] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(message(broken), "estimate: sample 17 of channel 1 is not a finite number (nan)");
  EXPECT_EQ(message_of([&] { (void)rwavs_metrics(broken, wave); }),
            "reference: sample 17 of channel 1 is not a finite number (nan)");
}

TEST(RwavsMetrics, OfTonesAreTheClosedForm) {
  // A tone in the middle of a bin: |S| there is the window's sum (256 for Hann) times half the
  // amplitude. The two neighbours have half of that, all others nothing.
  const std::ptrdiff_t samples = 22050;
  Waveform reference(2, samples, 22050);
  Waveform estimate(2, samples, 22050);
  for (std::ptrdiff_t n = 0; n < samples; ++n) {
    const double tone = std::sin(kTurn * 50.0 * static_cast<double>(n) / 512.0);
    reference.channel(0)[n] = static_cast<float>(0.4 * tone);
    reference.channel(1)[n] = static_cast<float>(0.2 * tone);
    estimate.channel(0)[n] = static_cast<float>(0.3 * tone);
    estimate.channel(1)[n] = static_cast<float>(0.2 * tone);
  }
  const RwavsMetrics metrics = rwavs_metrics(reference, estimate);
  const double peak = 256.0 * 0.1 / 2;
  const double expected = peak * peak * (1.0 + 0.25 + 0.25) / 257.0;
  // Four of 173 frames reach beyond the ends into zeros: 2.3 % at most.
  EXPECT_NEAR(metrics.mag, expected, 0.03 * expected);
  // The tone does not fit the length, so the envelope ripples at the ends.
  EXPECT_NEAR(metrics.env, 0.1, 2e-3);
}

TEST(RwavsMetrics, OfOtherRatesAreTakenAt22050Hz) {
  Waveform reference(2, 48000, 48000);
  Waveform estimate(2, 48000, 48000);
  Waveform direct_reference(2, 22050, 22050);
  Waveform direct_estimate(2, 22050, 22050);
  const auto fill = [](Waveform& wave, double frequency_hz) {
    for (int c = 0; c < 2; ++c) {
      for (std::ptrdiff_t n = 0; n < wave.samples(); ++n) {
        // Faded at the ends, which the resampler's filter would smear.
        const double t = static_cast<double>(n) / wave.sample_rate_hz();
        wave.channel(c)[n] = static_cast<float>(std::pow(std::sin(kTurn / 2 * t), 2) *
                                                std::sin(kTurn * frequency_hz * t + c));
      }
    }
  };
  fill(reference, 700.0);
  fill(estimate, 900.0);
  fill(direct_reference, 700.0);
  fill(direct_estimate, 900.0);
  const RwavsMetrics resampled = rwavs_metrics(reference, estimate);
  const RwavsMetrics direct = rwavs_metrics(direct_reference, direct_estimate);
  // The resampler is transparent to -140 dB, the samples to -150.
  EXPECT_NEAR(resampled.mag, direct.mag, 1e-5 * direct.mag);
  EXPECT_NEAR(resampled.env, direct.env, 1e-5);
}

TEST(FixSign, IsTheReleasedEvaluations) {
  for (const fs::path& folder : folders()) {
    const SafetensorsFile file = read_safetensors(folder / "signfix.safetensors");
    int changed = 0;
    for (int number = 0; number <= 6; ++number) {
      const std::string name = "case" + std::to_string(number);
      const Tensor& estimate = file.tensors.at(name + "_pred");
      const Tensor& fixed = file.tensors.at(name + "_fixed");
      std::vector<Waveform> estimates;
      std::vector<Waveform> references;
      for (std::int64_t i = 0; i < estimate.shape[0]; ++i) {
        estimates.push_back(clip_of(estimate, i));
        references.push_back(clip_of(file.tensors.at(name + "_tgt"), i));
      }
      const SignFix what = fix_sign(estimates, references);
      for (std::int64_t i = 0; i < estimate.shape[0]; ++i) {
        EXPECT_TRUE(std::ranges::equal(estimates[i].planar(), clip_of(fixed, i).planar()))
            << name << " clip " << i;
      }
      EXPECT_EQ(what == SignFix::none, estimate == fixed) << name;
      if (what != SignFix::none) ++changed;
    }
    EXPECT_GT(changed, 0);
  }
}

TEST(FixSign, NegatesTheEarThatDisagreesWithTheReference) {
  const Waveform reference = scaled(noise(100, 8), 1.0F, 1.0F);
  Waveform in_phase = reference;
  std::ranges::copy(reference.channel(0), in_phase.channel(1).begin());
  std::vector<Waveform> references{in_phase};

  std::vector<Waveform> estimates{scaled(in_phase, 1.0F, -0.5F)};
  EXPECT_EQ(fix_sign(estimates, references), SignFix::negated_right);
  EXPECT_TRUE(std::ranges::equal(estimates[0].planar(), scaled(in_phase, 1.0F, 0.5F).planar()));

  estimates = {scaled(in_phase, -1.0F, 0.5F)};
  EXPECT_EQ(fix_sign(estimates, references), SignFix::negated_left);
  EXPECT_TRUE(std::ranges::equal(estimates[0].planar(), scaled(in_phase, 1.0F, 0.5F).planar()));

  estimates = {scaled(in_phase, -1.0F, -0.5F)};
  EXPECT_EQ(fix_sign(estimates, references), SignFix::none);
}

}  // namespace
}  // namespace earpoint
