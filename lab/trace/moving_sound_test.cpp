#include "delayed_reader.h"
#include "gates/measurement.h"
#include "gates/rooms.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include <earpoint/audio/fft.h>
#include <earpoint/core/random.h>
#include <earpoint/trace/moving_sound.h>

namespace earpoint {
namespace {

using gates::omni;
using gates::open_air;

constexpr int kRate_hz = 16000;
constexpr double kAir_m_per_s = 343.2;

std::vector<float> tone(double frequency_hz, double duration_s) {
  std::vector<float> samples(static_cast<std::size_t>(duration_s * kRate_hz));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] = static_cast<float>(
        0.5 * std::sin(2.0 * kPi * frequency_hz * static_cast<double>(i) / kRate_hz));
  }
  return samples;
}

PoseOverTime still(const Vector3& place) {
  return [=](double) { return Pose{.position_m = place, .orientation = {}}; };
}

PoseOverTime straight(const Vector3& from, const Vector3& m_per_s) {
  return
      [=](double time_s) { return Pose{.position_m = from + m_per_s * time_s, .orientation = {}}; };
}

Waveform play(const Scene& room, const Motion& motion, const std::vector<float>& sound,
              const Microphone& microphone = {}, double duration_s = 0.2) {
  ThreadPool pool(1);
  TraceOptions options{.rays = 200, .mirror_rays = 2000, .duration_s = duration_s};
  options.air_absorbs = false;
  return trace_motion(AcousticScene(room), omni({}), motion, sound, kRate_hz, microphone, options,
                      pool);
}

// The mean frequency of a tone over a stretch, from its phase at both ends, by correlation.
double frequency_of(std::span<const float> samples, double near_hz, double from_s, double to_s) {
  constexpr int kHalf = 800;
  const auto phase_at = [&](double time_s) {
    std::complex<double> sum = 0.0;
    const auto middle = static_cast<std::ptrdiff_t>(time_s * kRate_hz);
    for (std::ptrdiff_t i = -kHalf; i <= kHalf; ++i) {
      const double window = 0.5 + 0.5 * std::cos(kPi * static_cast<double>(i) / kHalf);
      const double turn = -2.0 * kPi * near_hz * static_cast<double>(middle + i) / kRate_hz;
      sum += window * static_cast<double>(samples[middle + i]) * std::polar(1.0, turn);
    }
    return std::arg(sum);
  };
  // Hops are short, so that the phase relative to `near_hz` changes by less than half a turn.
  double turned = 0.0;
  const int hops = 20;
  for (int hop = 0; hop < hops; ++hop) {
    const double a = from_s + (to_s - from_s) * hop / hops;
    const double b = from_s + (to_s - from_s) * (hop + 1) / hops;
    turned += std::remainder(phase_at(b) - phase_at(a), 2.0 * kPi);
  }
  return near_hz + turned / (2.0 * kPi * (to_s - from_s));
}

TEST(MovingSound, SourceThatComesNearerIsHigherByDoppler) {
  const Motion motion{.world_from_source = straight({30, 0, 0}, {-10, 0, 0}),
                      .world_from_listener = still({0, 0, 0})};
  const Waveform heard = play(open_air(), motion, tone(1000.0, 1.5));
  const double expected_hz = 1000.0 / (1.0 - 10.0 / kAir_m_per_s);
  // A hundredth of the requirement, which is 0.1 %.
  EXPECT_NEAR(frequency_of(heard.channel(0), expected_hz, 0.3, 1.3), expected_hz, 0.01);
}

TEST(MovingSound, ListenerWhoLeavesHearsLowerByDoppler) {
  const Motion motion{.world_from_source = still({0, 0, 0}),
                      .world_from_listener = straight({5, 0, 0}, {8, 0, 0})};
  const Waveform heard = play(open_air(), motion, tone(1000.0, 1.5));
  const double expected_hz = 1000.0 * (1.0 - 8.0 / kAir_m_per_s);
  // As above.
  EXPECT_NEAR(frequency_of(heard.channel(0), expected_hz, 0.3, 1.3), expected_hz, 0.01);
}

TEST(MovingSound, ReflectionHasADopplerShiftOfItsOwn) {
  // Towards a rigid wall the direct sound of a source behind is lower and the echo higher. The
  // sound of the same walk without the wall is subtracted.
  Scene scene = open_air();
  const AcousticMaterial rigid{.name = "wall",
                               .absorption = all_bands(0.0F),
                               .scattering = all_bands(0.0F),
                               .transmission = all_bands(0.0F),
                               .source = {}};
  gates::add_block(scene, {-20, 10, -20}, {20, 11, 20}, rigid);
  const Motion motion{.world_from_source = still({0, 0, 0}),
                      .world_from_listener = straight({0.5, 2, 0}, {0, 3, 0})};
  const std::vector<float> sound = tone(1000.0, 1.2);
  const Waveform both = play(scene, motion, sound);
  const Waveform direct = play(open_air(), motion, sound);
  std::vector<float> echo(both.channel(0).begin(), both.channel(0).end());
  for (std::size_t i = 0; i < echo.size(); ++i) echo[i] -= direct.channel(0)[i];
  // The image is at y = 20 and comes nearer by 3 m/s, except for the small angle, which takes 0.005
  // Hz. A twentieth of the requirement.
  const double expected_hz = 1000.0 * (1.0 + 3.0 / kAir_m_per_s);
  EXPECT_NEAR(frequency_of(echo, expected_hz, 0.3, 1.0), expected_hz, 0.05);
}

TEST(MovingSound, LevelFollowsTheDistanceBetweenSteps) {
  const Motion motion{.world_from_source = still({0, 0, 0}),
                      .world_from_listener = straight({2, 0, 0}, {4, 0, 0}),
                      .step_s = 0.2};
  const Waveform heard = play(open_air(), motion, tone(500.0, 1.2));
  for (const double time_s : {0.3, 0.45, 0.5, 0.9}) {
    double sum = 0.0;
    constexpr int kSamples = 320;  // ten periods
    const auto middle = static_cast<std::ptrdiff_t>(time_s * kRate_hz);
    for (int i = -kSamples / 2; i < kSamples / 2; ++i) {
      const double value = static_cast<double>(heard.channel(0)[middle + i]);
      sum += value * value / kSamples;
    }
    // 1 % is 0.1 dB, of which air takes 0.02 dB at 500 Hz.
    const double expected = 0.5 / std::sqrt(2.0) / (2.0 + 4.0 * time_s);
    EXPECT_NEAR(std::sqrt(sum) / expected, 1.0, 0.01) << time_s;
  }
}

// The largest level outside of a band around a tone, relative to the tone, in windows of 32 ms.
double clicks_db(std::span<const float> samples, double tone_hz, double from_s, double to_s) {
  constexpr int kSize = 512;
  RealFft<double> fft(kSize);
  std::vector<double> block(kSize);
  std::vector<std::complex<double>> spectrum(fft.bins());
  double worst = 0.0;
  double level = 0.0;
  for (auto at = static_cast<std::ptrdiff_t>(from_s * kRate_hz);
       at + kSize < static_cast<std::ptrdiff_t>(to_s * kRate_hz); at += kSize / 4) {
    for (int i = 0; i < kSize; ++i) {
      const double turn = 2.0 * kPi * i / kSize;
      // The Blackman-Harris window: -92 dB outside of its four bins.
      const double window = 0.35875 - 0.48829 * std::cos(turn) + 0.14128 * std::cos(2.0 * turn) -
                            0.01168 * std::cos(3.0 * turn);
      block[i] = window * static_cast<double>(samples[at + i]);
    }
    fft.forward(block, spectrum);
    double outside = 0.0;
    double inside = 0.0;
    for (int bin = 0; bin < fft.bins(); ++bin) {
      const double frequency_hz = static_cast<double>(bin) * kRate_hz / kSize;
      (std::abs(frequency_hz - tone_hz) < 0.05 * tone_hz + 250.0 ? inside : outside) +=
          std::norm(spectrum[bin]);
    }
    worst = std::max(worst, outside);
    level = std::max(level, inside);
  }
  return gates::decibels(worst / level);
}

TEST(MovingSound, WalkThroughARoomHasNoClicks) {
  const Scene room = make_shoebox({6, 5, 3}, all_bands(0.3F), all_bands(0.3F));
  const Motion motion{.world_from_source = straight({1, 1, 1.5}, {1.2, 0.4, 0}),
                      .world_from_listener = [](double time_s) {
                        return Pose{
                            .position_m = {4.5 - 0.8 * time_s, 3.5, 1.6},
                            .orientation = quaternion_from_euler({.yaw_rad = 1.5 * time_s})};
                      }};
  const HrtfSet hrtf = HrtfSet::load(kRate_hz);
  const Waveform heard = play(room, motion, tone(1000.0, 1.2), {.ears = hrtf}, 0.3);
  ASSERT_EQ(heard.channels(), 2);
  // After the onset and before the end of the tone, which are clicks themselves.
  for (int ear = 0; ear < 2; ++ear) {
    EXPECT_LT(clicks_db(heard.channel(ear), 1000.0, 0.45, 1.15), -60.0) << ear;
  }
}

TEST(MovingSound, StandingStillIsTheResponseOfThePlace) {
  const Scene room = make_shoebox({6, 5, 3}, all_bands(0.3F), all_bands(0.3F));
  const Vector3 from{1, 1, 1.5};
  const Vector3 to{4.5, 3.5, 1.6};
  std::vector<float> sound(kRate_hz / 2);
  RandomStream random(1);
  for (std::size_t i = 0; i < sound.size(); ++i) {
    sound[i] = static_cast<float>(0.1 * random.normal());
  }
  const Microphone microphone{.ambisonic_order = 1};
  const Waveform moving =
      play(room, {.world_from_source = still(from), .world_from_listener = still(to)}, sound,
           microphone, 0.3);
  ThreadPool pool(1);
  TraceOptions options{.rays = 200, .mirror_rays = 2000, .duration_s = 0.3};
  options.air_absorbs = false;
  const Source source = omni(from);
  const TraceResult traced = trace(AcousticScene(room), {&source, 1}, {&to, 1}, options, pool);
  const ResponseSynthesizer synthesizer({.sample_rate_hz = kRate_hz, .duration_s = 0.3});
  const Waveform response = synthesizer.ambisonic(traced.responses[0][0], {}, 1, 0);
  ASSERT_EQ(moving.channels(), 4);
  const std::ptrdiff_t samples = moving.samples();
  RealFft<double> fft(fast_fft_size(static_cast<int>(2 * samples)));
  const auto spectrum_of = [&](std::span<const float> signal) {
    std::vector<double> padded(fft.size());
    std::ranges::copy(signal, padded.begin());
    std::vector<std::complex<double>> spectrum(fft.bins());
    fft.forward(padded, spectrum);
    return spectrum;
  };
  const auto in = spectrum_of(sound);
  for (int channel = 0; channel < 4; ++channel) {
    const auto out = spectrum_of(moving.channel(channel));
    const auto filter = spectrum_of(response.channel(channel));
    double error = 0.0;
    double all = 0.0;
    // Up to where the spectrum of single responses rolls off.
    for (int bin = 0; bin < static_cast<int>(0.9 * fft.bins()); ++bin) {
      error += std::norm(out[bin] - in[bin] * filter[bin]);
      all += std::norm(in[bin] * filter[bin]);
    }
    // Each part of a response is faded in before its first sound, which cuts some ringing of its
    // filters.
    EXPECT_LT(gates::decibels(error / all), -45.0) << channel;
  }
}

TEST(DelayedReader, IsExactBetweenSamplesOfALowSound) {
  const DelayedReader reader;
  std::vector<float> signal(200);
  const double radians = 0.49 * kPi;  // the highest that it takes
  for (std::size_t i = 0; i < signal.size(); ++i) {
    signal[i] = static_cast<float>(std::sin(radians * static_cast<double>(i)));
  }
  for (double position = 50.0; position < 60.0; position += 0.0371) {
    // -80 dB, as delayed_reader.h promises.
    EXPECT_NEAR(reader.at(signal, position), std::sin(radians * position), 1e-4);
  }
  EXPECT_EQ(reader.at(signal, -30.0), 0.0F);
  EXPECT_EQ(reader.at(signal, 400.0), 0.0F);
}

TEST(SmoothCurve, PassesThroughItsPointsAndKeepsParabolas) {
  std::vector<double> values;
  for (int i = 0; i < 10; ++i) values.push_back(0.5 * i * i - 3.0 * i);
  const SmoothCurve curve(2.0, 0.5, values);
  for (double place = 1.0; place < 8.0; place += 0.13) {
    EXPECT_NEAR(curve.at(2.0 + 0.5 * place), 0.5 * place * place - 3.0 * place, 1e-12);
  }
}

}  // namespace
}  // namespace earpoint
