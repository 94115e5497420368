#include "interaural_delay.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/fft.h>
#include <earpoint/core/random.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

/// Noise from 100 Hz to 6 kHz that repeats every second, the right ear later by `delay_s`.
Waveform noise(double delay_s) {
  Waveform sound(2, 16000, 16000);
  RealFft<float> fft(16000);
  for (int ear = 0; ear < 2; ++ear) {
    RandomStream random(4);
    std::vector<std::complex<float>> spectrum(static_cast<std::size_t>(fft.bins()));
    for (int hz = 100; hz < 6000; ++hz) {
      const double late_rad = ear == 1 ? 2.0 * kPi * hz * delay_s : 0.0;
      spectrum[hz] = std::polar(10.0F, static_cast<float>(2.0 * kPi * random.uniform() - late_rad));
    }
    fft.inverse(spectrum, sound.channel(ear));
  }
  return sound;
}

TEST(InterauralDelay, FractionalDelayIsFound) {
  InterauralDelay delay;
  for (const double expected_s : {-613e-6, -31.25e-6, 0.0, 40e-6, 250e-6, 881e-6}) {
    // 0.02 sample is 1.25 us: the peak is not quite a parabola, and the fades differ.
    EXPECT_NEAR(delay.measure_s(noise(expected_s)).value(), expected_s, 1.25e-6);
  }
}

TEST(InterauralDelay, BeyondAMillisecondNothingIsLookedFor) {
  InterauralDelay delay;
  EXPECT_LE(std::abs(delay.measure_s(noise(5e-3)).value()), 1e-3);
}

TEST(InterauralDelay, SilentEarHasNone) {
  Waveform sound = noise(0.0);
  std::ranges::fill(sound.channel(1), 0.0F);
  EXPECT_FALSE(InterauralDelay().measure_s(sound).has_value());
}

}  // namespace
}  // namespace earpoint
