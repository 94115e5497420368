#include <cmath>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/window_of.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/synthesis/dsp_synthesizer.h>

namespace earpoint {
namespace {

constexpr int kRate_hz = 16000;

/// Noise at `speaker_m` at KEMAR's ears in the free field: 2 ears, [samples].
Waveform heard_from(const Vector3& speaker_m, std::ptrdiff_t samples) {
  const Hrir hrir = HrtfSet::load(kRate_hz).interpolated(speaker_m);
  std::vector<float> noise(static_cast<std::size_t>(samples));
  RandomStream random(3);
  for (float& sample : noise) sample = static_cast<float>(0.1 * random.normal());
  Waveform sound(2, samples, kRate_hz);
  for (int ear = 0; ear < 2; ++ear) {
    const std::vector<float> filtered = convolve(noise, hrir.taps[ear]);
    for (std::ptrdiff_t i = 0; i < samples; ++i) {
      sound.channel(ear)[i] = filtered[i] * static_cast<float>(distance_gain(norm(speaker_m)));
    }
  }
  return sound;
}

std::array<double, 2> level_db(const Waveform& sound) {
  std::array<double, 2> level{};
  for (int ear = 0; ear < 2; ++ear) {
    double energy = 0.0;
    for (const float sample : sound.channel(ear)) energy += static_cast<double>(sample) * sample;
    level[ear] = 10.0 * std::log10(energy / static_cast<double>(sound.samples()));
  }
  return level;
}

/// What the source hears around a window.
Waveform heard_around(DspSynthesizer& dsp, const Vector3& speaker_m) {
  const WindowShape shape = dsp.window_shape(kRate_hz);
  return heard_from(speaker_m, shape.samples + 2 * shape.context);
}

/// The middle of a long stationary sound as one window.
Waveform render_window(DspSynthesizer& dsp, const Vector3& speaker_m, const Pose& target) {
  Observation observation;
  observation.sound = heard_around(dsp, speaker_m);
  observation.speaker_m = speaker_m;
  dsp.observe(observation);
  return dsp.synthesize(target);
}

DspSynthesizer make_dsp() { return DspSynthesizer(std::nullopt, radians_from_degrees(90.0)); }

TEST(DspSynthesizer, TurningTheHeadLeftMovesASpeakerInFrontToTheRight) {
  DspSynthesizer dsp = make_dsp();
  const Pose left{{}, quaternion_from_euler({.yaw_rad = kPi / 2})};
  const auto ahead = level_db(render_window(dsp, {2, 0, 0}, Pose{}));
  const auto turned = level_db(render_window(dsp, {2, 0, 0}, left));
  EXPECT_NEAR(ahead[0] - ahead[1], 0.0, 1e-3);  // KEMAR's set is symmetric: rounding of float32
  // The head's shadow for broadband noise at 90 degrees is well above 5 dB.
  EXPECT_LT(turned[0], turned[1] - 5.0);
}

TEST(DspSynthesizer, HalvingTheDistanceAddsSixDecibels) {
  DspSynthesizer dsp = make_dsp();
  const auto far = level_db(render_window(dsp, {4, 0, 0}, Pose{}));
  const auto near = level_db(render_window(dsp, {4, 0, 0}, Pose{{2, 0, 0}, {}}));
  for (int ear = 0; ear < 2; ++ear) {
    // The same filters but for the gain: only rounding differs.
    EXPECT_NEAR(near[ear] - far[ear], 6.02, 0.01);
  }
}

TEST(DspSynthesizer, StandingWhereTheSourceStoodKeepsEachEarsLevel) {
  DspSynthesizer dsp = make_dsp();
  const Vector3 speaker{2, 1, 0};
  const WindowShape shape = dsp.window_shape(kRate_hz);
  const auto recorded =
      level_db(window_of(heard_around(dsp, speaker), shape.context, shape.samples));
  const auto rendered = level_db(render_window(dsp, speaker, Pose{}));
  for (int ear = 0; ear < 2; ++ear) {
    // Regularisation takes 0.01 dB.
    EXPECT_NEAR(rendered[ear], recorded[ear], 0.05) << ear;
  }
}

TEST(DspSynthesizer, SaysWhatItNeeds) {
  DspSynthesizer dsp = make_dsp();
  Observation observation;
  const auto error = [&] {
    try {
      dsp.observe(observation);
    } catch (const InputError& problem) {
      return std::string(problem.what());
    }
    return std::string("no error");
  };
  EXPECT_NE(error().find("speaker's position"), std::string::npos);
  observation.speaker_box = Box{0.4, 0.2, 0.6, 0.9};
  EXPECT_NE(error().find("without a picture"), std::string::npos);
  const Image picture(256, 256, 3);
  observation.picture = std::make_shared<const Image>(picture);
  EXPECT_EQ(error(), "no error");
  EXPECT_THROW(DspSynthesizer("missing.sofa", 1.5), InputError);
}

}  // namespace
}  // namespace earpoint
