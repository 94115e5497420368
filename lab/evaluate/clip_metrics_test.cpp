#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/decay.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/clip_metrics.h>
#include <earpoint/evaluate/speech_metrics.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 16000;

Waveform noise(int channels, std::ptrdiff_t samples, std::uint64_t seed) {
  RandomStream random(seed);
  Waveform sound(channels, samples, kRate_hz);
  for (float& x : sound.planar()) x = static_cast<float>(0.1 * random.normal());
  return sound;
}

Waveform scaled(Waveform sound, float left, float right) {
  for (float& x : sound.channel(0)) x *= left;
  for (float& x : sound.channel(1)) x *= right;
  return sound;
}

/// A direct sound and a tail that decays by 60 dB in `t60_s`, 0.4 s long, in both ears.
Waveform room(double t60_s, std::uint64_t seed) {
  Waveform response(2, 6400, kRate_hz);
  RandomStream random(seed);
  for (int ear = 0; ear < 2; ++ear) {
    const auto taps = response.channel(ear);
    for (std::size_t n = 0; n < taps.size(); ++n) {
      const double decay = std::pow(10.0, -3.0 * static_cast<double>(n) / (t60_s * kRate_hz));
      taps[n] = static_cast<float>(0.05 * decay * random.normal());
    }
    taps[0] = 1.0F;
  }
  return response;
}

/// `dry` convolved with a response, from sample `lead` on.
Waveform heard(const Waveform& dry, const Waveform& response, std::ptrdiff_t lead) {
  Waveform sound(2, dry.samples() - lead, kRate_hz);
  for (int ear = 0; ear < 2; ++ear) {
    const std::vector<float> whole = convolve(dry.channel(0), response.channel(ear));
    std::copy_n(whole.begin() + lead, sound.samples(), sound.channel(ear).begin());
  }
  return sound;
}

TEST(ClipMeasurer, OfTheTargetItselfIsZeroThroughout) {
  const Waveform target = noise(2, kRate_hz, 1);
  PairTruth truth{.dry = noise(1, kRate_hz + 6399, 2),
                  .lead = 6399,
                  .source_response = {},
                  .target_response = {}};
  const Waveform in_room = heard(truth.dry, room(0.5, 3), truth.lead);
  ClipMeasurer measurer([](const Waveform&) { return std::vector<double>{0.3, 0.4}; });
  measurer.set_target(in_room, &truth);
  const ClipMetrics metrics = measurer.measure(in_room);
  for (const Metric metric : all_metrics()) {
    if (name_of(metric).is_error) {
      EXPECT_EQ(metrics[metric], 0.0) << name_of(metric).key;
    } else {
      EXPECT_FALSE(metrics[metric].has_value()) << name_of(metric).key;
    }
  }
}

TEST(ClipMeasurer, JudgesSpeechWhereItIsAskedTo) {
  const Waveform target = noise(2, kRate_hz, 1);
  ClipMeasurer measurer({}, true);
  measurer.set_target(target, nullptr);
  const ClipMetrics itself = measurer.measure(target);
  EXPECT_EQ(itself[Metric::si_sdr], kLargestSiSdrDb);
  EXPECT_NEAR(itself[Metric::estoi].value(), 1.0, 1e-6);  // a normalised correlation's rounding
  // Each ear is compared with its own target: noise of the left ear's level gives 0 dB there and no
  // error at the right.
  Waveform other = target;
  const Waveform more = noise(1, kRate_hz, 7);
  for (std::ptrdiff_t i = 0; i < other.samples(); ++i) {
    other.channel(0)[i] += more.channel(0)[i];
  }
  const ClipMetrics half = measurer.measure(other);
  // 16000 values: the ratio of two energies is good to 0.1 dB.
  EXPECT_NEAR(half[Metric::si_sdr].value(), (kLargestSiSdrDb + 0.0) / 2.0, 0.2);
  EXPECT_GT(half[Metric::estoi].value(), 0.5);
  EXPECT_LT(half[Metric::estoi].value(), 0.95);
}

TEST(ClipMeasurer, LevelErrorIsTheMeanOverTheEars) {
  const Waveform target = noise(2, kRate_hz, 1);
  ClipMeasurer measurer({});
  measurer.set_target(target, nullptr);
  const double half_db = 20.0 * std::log10(2.0);
  const ClipMetrics metrics = measurer.measure(scaled(target, 2.0F, 0.25F));
  // Float samples: doubling and halving are exact.
  EXPECT_NEAR(metrics[Metric::level].value(), 1.5 * half_db, 1e-9);
  EXPECT_NEAR(metrics[Metric::lre].value(), 3.0 * half_db, 1e-5);
  EXPECT_NEAR(metrics[Metric::interaural_delay].value(), 0.0, 1e-6);
  // These need an estimator of RT60 or the dry speech.
  EXPECT_FALSE(metrics[Metric::rte].has_value());
  EXPECT_FALSE(metrics[Metric::early_decay].has_value());
  EXPECT_FALSE(metrics[Metric::clarity].has_value());
}

TEST(ClipMeasurer, RteIsTheMeanOverTheEars) {
  const Waveform target = noise(2, kRate_hz, 1);
  const Waveform other = noise(2, kRate_hz, 2);
  ClipMeasurer measurer([&](const Waveform& sound) {
    return std::ranges::equal(sound.planar(), target.planar()) ? std::vector<double>{0.5, 0.6}
                                                               : std::vector<double>{0.9, 0.4};
  });
  measurer.set_target(target, nullptr);
  EXPECT_NEAR(measurer.measure(other)[Metric::rte].value(), 0.3, 1e-12);
}

TEST(ClipMeasurer, DelayedRightEarIsTheInterauralError) {
  const Waveform both = noise(1, kRate_hz + 20, 5);
  const auto delayed = [&](std::ptrdiff_t left, std::ptrdiff_t right) {
    Waveform sound(2, kRate_hz, kRate_hz);
    std::copy_n(both.channel(0).begin() + 20 - left, kRate_hz, sound.channel(0).begin());
    std::copy_n(both.channel(0).begin() + 20 - right, kRate_hz, sound.channel(1).begin());
    return sound;
  };
  ClipMeasurer measurer({});
  measurer.set_target(delayed(0, 4), nullptr);
  // 4 samples later against 6 samples earlier, of 62.5 us each; the delay is found to 0.02 sample.
  EXPECT_NEAR(measurer.measure(delayed(6, 0))[Metric::interaural_delay].value(), 625.0, 1.25);
}

TEST(ClipMeasurer, DecayErrorsAreThoseOfTheResponses) {
  PairTruth truth{.dry = noise(1, kRate_hz + 6399, 7),
                  .lead = 6399,
                  .source_response = {},
                  .target_response = {}};
  const Waveform reference = room(0.3, 8);
  const Waveform estimate = room(0.6, 9);
  ClipMeasurer measurer({});
  measurer.set_target(heard(truth.dry, reference, truth.lead), &truth);
  const ClipMetrics metrics = measurer.measure(heard(truth.dry, estimate, truth.lead));
  double decay_s = 0.0;
  double clarity_db = 0.0;
  for (int ear = 0; ear < 2; ++ear) {
    decay_s += 0.5 * std::abs(early_decay_time_s(reference.channel(ear), kRate_hz) -
                              early_decay_time_s(estimate.channel(ear), kRate_hz));
    clarity_db += 0.5 * std::abs(clarity_c50_db(reference.channel(ear), kRate_hz) -
                                 clarity_c50_db(estimate.channel(ear), kRate_hz));
  }
  ASSERT_GT(decay_s, 0.1);
  ASSERT_GT(clarity_db, 2.0);
  // Noise has all frequencies, so that the fit recovers the responses up to the regularisation.
  EXPECT_NEAR(metrics[Metric::early_decay].value(), decay_s, 0.05 * decay_s);
  EXPECT_NEAR(metrics[Metric::clarity].value(), clarity_db, 0.05 * clarity_db);
}

TEST(ClipMeasurer, AnEarThatHearsEarlyDecaysAsItDid) {
  constexpr std::ptrdiff_t kEarly = 8;  // half a millisecond, as for a voice at the side
  const PairTruth truth{.dry = noise(1, kRate_hz + 6399, 2),
                        .lead = 6399,
                        .source_response = {},
                        .target_response = {}};
  const Waveform target = heard(truth.dry, room(0.5, 3), truth.lead);
  const Waveform earlier = heard(truth.dry, room(0.5, 3), truth.lead + kEarly);
  Waveform early = target;
  std::ranges::copy(earlier.channel(0), early.channel(0).begin());
  ClipMeasurer measurer({});
  measurer.set_target(target, &truth);
  const ClipMetrics metrics = measurer.measure(early);
  // The last 8 of 16,000 samples are not shifted.
  EXPECT_LT(metrics[Metric::early_decay].value(), 0.01);
  EXPECT_LT(metrics[Metric::clarity].value(), 0.1);
}

TEST(ClipMeasurer, SilentEarHasNoLevelErrorAndNanIsRefused) {
  const Waveform target = noise(2, kRate_hz, 1);
  ClipMeasurer measurer({});
  measurer.set_target(target, nullptr);
  const ClipMetrics metrics = measurer.measure(scaled(target, 1.0F, 0.0F));
  EXPECT_FALSE(metrics[Metric::level].has_value());
  EXPECT_FALSE(metrics[Metric::interaural_delay].has_value());
  Waveform broken = target;
  broken.channel(0)[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW((void)measurer.measure(broken), InputError);
  EXPECT_THROW(measurer.set_target(broken, nullptr), InputError);
}

}  // namespace
}  // namespace earpoint
