#include "diffuse_noise.h"

#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include <earpoint/audio/fft.h>
#include <earpoint/pose.h>
#include <earpoint/record_simulation/device_sound.h>

namespace earpoint {
namespace {

double tone(double frequency_hz, double time_s) {
  return std::sin(2.0 * kPi * frequency_hz * time_s);
}

TEST(DeviceClock, AToneIsHeardOnTheDevicesOwnTime) {
  constexpr int kRate_hz = 48000;
  for (const double frequency_hz : {440.0, 15000.0}) {
    Waveform sound(1, kRate_hz, kRate_hz);
    for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
      sound.channel(0)[i] =
          static_cast<float>(tone(frequency_hz, static_cast<double>(i) / kRate_hz));
    }
    const DeviceClock clock{.name = "1", .offset_s = 0.1234567, .drift_ppm = 80.0};
    const Waveform recorded = recorded_by(clock, sound, 0.9);
    EXPECT_EQ(recorded.samples(),
              static_cast<std::ptrdiff_t>((0.9 - 0.1234567) * (1.0 + 80e-6) * kRate_hz));
    for (std::ptrdiff_t i = 0; i < recorded.samples(); ++i) {
      const double time_s = 0.1234567 + static_cast<double>(i) / kRate_hz / (1.0 + 80e-6);
      // Interpolation error of -90 dB, and at 15 kHz the pass band's ripple of 0.01 dB.
      EXPECT_NEAR(recorded.channel(0)[i], tone(frequency_hz, time_s), 1.2e-3) << i;
    }
  }
}

/// Coherence of two signals over a band, by averaged cross spectra.
double coherence(const Waveform& sound, double low_hz, double high_hz) {
  constexpr int kSize = 1024;
  RealFft<float> fft(kSize);
  std::vector<std::complex<float>> left(fft.bins());
  std::vector<std::complex<float>> right(fft.bins());
  std::vector<std::complex<double>> cross(fft.bins());
  std::vector<double> power_left(fft.bins());
  std::vector<double> power_right(fft.bins());
  for (std::ptrdiff_t begin = 0; begin + kSize <= sound.samples(); begin += kSize) {
    fft.forward(sound.channel(0).subspan(begin, kSize), left);
    fft.forward(sound.channel(1).subspan(begin, kSize), right);
    for (int bin = 0; bin < fft.bins(); ++bin) {
      cross[bin] += std::complex<double>(left[bin] * std::conj(right[bin]));
      power_left[bin] += std::norm(left[bin]);
      power_right[bin] += std::norm(right[bin]);
    }
  }
  double sum = 0.0;
  int count = 0;
  for (int bin = 1; bin < fft.bins(); ++bin) {
    const double frequency_hz = static_cast<double>(bin) * sound.sample_rate_hz() / kSize;
    if (frequency_hz < low_hz || frequency_hz > high_hz) continue;
    sum += std::abs(cross[bin]) / std::sqrt(power_left[bin] * power_right[bin]);
    ++count;
  }
  return sum / count;
}

TEST(DiffuseNoise, IsCoherentBetweenTheEarsAtLowFrequenciesOnly) {
  RandomStream random(3);
  const Waveform noise = DiffuseNoise(HrtfSet::load(48000)).make(48000 * 6, random);
  // A diffuse field 0.15 to 0.2 m apart: sin(x)/x of 0.9 and more below 200 Hz; by 2 kHz several
  // zeros have passed. 280 averages of noise alone give 0.06.
  EXPECT_GT(coherence(noise, 90.0, 200.0), 0.85);
  EXPECT_LT(coherence(noise, 2000.0, 8000.0), 0.25);
}

TEST(DiffuseNoise, HasAMeanSquareOfOne) {
  RandomStream random(4);
  for (const Waveform& noise : {DiffuseNoise(48000).make(48000 * 8, random),
                                DiffuseNoise(HrtfSet::load(48000)).make(48000 * 8, random)}) {
    double sum = 0.0;
    for (const float sample : noise.planar()) sum += static_cast<double>(sample) * sample;
    // Pink noise from 60 Hz on: its lowest band has some 500 independent values in 8 s, and a
    // fraction of the power.
    EXPECT_NEAR(sum / static_cast<double>(noise.planar().size()), 1.0, 0.08);
  }
}

}  // namespace
}  // namespace earpoint
