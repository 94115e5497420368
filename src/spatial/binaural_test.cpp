#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/fft.h>
#include <earpoint/core/random.h>
#include <earpoint/spatial/binaural.h>

namespace earpoint {
namespace {

constexpr int kRate = 16000;
constexpr int kBlock = 160;

const HrtfSet& hrtf() {
  static const HrtfSet set = HrtfSet::load(kRate);
  return set;
}

std::vector<float> noise(int samples) {
  RandomStream random(7);
  std::vector<float> result(samples);
  for (float& sample : result) sample = static_cast<float>(0.1 * random.normal());
  return result;
}

// Pans a sound along a path, one place per block.
template <typename Path>
Waveform pan(std::span<const float> mono, Path path) {
  BinauralPanner panner(hrtf(), kBlock);
  Waveform out(2, std::ssize(mono), kRate);
  for (std::ptrdiff_t at = 0; at + kBlock <= std::ssize(mono); at += kBlock) {
    panner.process(mono.subspan(at, kBlock), path(static_cast<double>(at + kBlock) / kRate),
                   out.channel(0).subspan(at, kBlock), out.channel(1).subspan(at, kBlock));
  }
  return out;
}

double level_db(std::span<const float> samples) {
  double sum = 0.0;
  for (const float sample : samples) sum += static_cast<double>(sample) * sample;
  return 10.0 * std::log10(sum / static_cast<double>(samples.size()));
}

TEST(BinauralPanner, AStillSourceIsPlainConvolution) {
  const std::vector<float> mono = noise(8000);
  const Spherical place{radians_from_degrees(50.0), 0.1, 2.0};
  const Waveform found = pan(mono, [&](double) { return place; });
  const Hrir hrir =
      hrtf().interpolated(cartesian_from_spherical({place.azimuth_rad, place.elevation_rad, 1.0}));
  for (int ear = 0; ear < 2; ++ear) {
    const std::vector<float> expected = convolve(mono, hrir.taps[ear]);
    for (std::ptrdiff_t i = 0; i < found.samples(); ++i) {
      // Distance gain 0.1; float transforms.
      ASSERT_NEAR(found.channel(ear)[i], 0.1F * expected[i], 1e-6F) << i;
    }
  }
}

TEST(BinauralPanner, WholeSoundsComeInStepWithTheMiddleOfTheHead) {
  const std::vector<float> mono = noise(4000);
  const Spherical front{0.0, 0.0, 1.0};
  const Waveform streamed = pan(mono, [&](double) { return front; });
  const Waveform whole = pan_binaural(mono, hrtf(), front);
  const int delay = BinauralPanner(hrtf(), kBlock).delay_samples();
  for (std::ptrdiff_t i = 0; i + delay < whole.samples(); ++i) {
    ASSERT_NEAR(whole.channel(1)[i], streamed.channel(1)[i + delay], 1e-6F);  // as above
  }
}

TEST(BinauralPanner, AVoiceWalkingAroundTheHeadGoesFromEarToEar) {
  const std::vector<float> mono = noise(4 * kRate);
  // Once around in 4 s, from the front to the left.
  const Waveform out = pan(mono, [](double time_s) {
    return Spherical{wrap_angle(2.0 * kPi * time_s / 4.0), 0.0, 1.0};
  });
  const auto difference = [&](double at_s) {
    const auto from = static_cast<std::ptrdiff_t>((at_s - 0.1) * kRate);
    return level_db(out.channel(0).subspan(from, kRate / 5)) -
           level_db(out.channel(1).subspan(from, kRate / 5));
  };
  // Behind, 18 degrees of the walk lie as much on the left as on the right, but for the noise.
  EXPECT_GT(difference(1.0), 6.0);         // left
  EXPECT_NEAR(difference(2.0), 0.0, 1.0);  // behind
  EXPECT_LT(difference(3.0), -6.0);        // right
}

TEST(BinauralPanner, AMovingToneHasNoClicks) {
  // A tone of 1 kHz moves around the head in 2 s, in blocks of 12 ms: anything above 3 kHz is a
  // click.
  std::vector<float> tone(2 * kRate);
  for (std::size_t i = 0; i < tone.size(); ++i) {
    tone[i] =
        static_cast<float>(0.5 * std::sin(2.0 * kPi * 1000.0 / kRate * static_cast<double>(i)));
  }
  const Waveform out = pan(tone, [](double time_s) {
    return Spherical{wrap_angle(kPi * time_s), 0.3 * std::sin(3.0 * time_s), 1.0 + 0.5 * time_s};
  });
  constexpr int kSize = 16384;
  RealFft<double> fft(kSize);
  for (int ear = 0; ear < 2; ++ear) {
    std::vector<double> windowed(kSize);
    for (int i = 0; i < kSize; ++i) {
      const double hann = 0.5 - 0.5 * std::cos(2.0 * kPi * (i + 0.5) / kSize);
      windowed[i] = hann * hann * out.channel(ear)[8000 + i];
    }
    std::vector<std::complex<double>> spectrum(fft.bins());
    fft.forward(windowed, spectrum);
    double tone_power = 0.0;
    double click_power = 0.0;
    for (int bin = 0; bin < fft.bins(); ++bin) {
      const double frequency_hz = static_cast<double>(bin) * kRate / kSize;
      if (std::abs(frequency_hz - 1000.0) < 200.0) tone_power += std::norm(spectrum[bin]);
      if (frequency_hz > 3000.0) click_power += std::norm(spectrum[bin]);
    }
    // Measured: -118 dB; switching the filters instead of fading gives -53 dB.
    EXPECT_LT(10.0 * std::log10(click_power / tone_power), -100.0) << ear;
  }
}

TEST(BinauralPanner, RefusesBlocksOfAnotherSize) {
  BinauralPanner panner(hrtf(), kBlock);
  std::vector<float> samples(kBlock + 1);
  EXPECT_THROW(panner.process(samples, {0, 0, 1}, samples, samples), std::logic_error);
}

}  // namespace
}  // namespace earpoint
