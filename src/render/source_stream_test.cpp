#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/stereo_check.h>
#include <earpoint/core/random.h>
#include <earpoint/pose.h>
#include <earpoint/render/source_stream.h>
#include <earpoint/spatial/hrtf.h>

namespace earpoint {
namespace {

constexpr int kRate = 16000;

/// Two seconds of noise in syllables, with a spectrum that falls like that of speech.
std::vector<float> syllables() {
  RandomStream random(5);
  std::vector<float> sound(2 * kRate);
  double low = 0.0;
  for (std::size_t i = 0; i < sound.size(); ++i) {
    low += 0.3 * (random.uniform(-1.0, 1.0) - low);
    const double loud = std::max(0.0, std::sin(25.0 * static_cast<double>(i) / kRate));
    sound[i] = static_cast<float>(0.5 * loud * low);
  }
  return sound;
}

Waveform two_ears(const std::vector<float>& left, const std::vector<float>& right) {
  Waveform wave(2, std::ssize(left), kRate);
  std::ranges::copy(left, wave.channel(0).begin());
  std::ranges::copy(right, wave.channel(1).begin());
  return wave;
}

TEST(StereoOfDryBinauralSound, IsPlausibleFromAllSidesAndSameOnlyInTheMiddle) {
  // The hardest case: no room, one still source, a head whose measured halves are mirror images.
  const HrtfSet hrtf = HrtfSet::load(kRate);
  const std::vector<float> sound = syllables();
  for (const int elevation_deg : {-30, 0, 30}) {
    for (int azimuth_deg = -180; azimuth_deg < 180; azimuth_deg += 15) {
      const double azimuth = radians_from_degrees(azimuth_deg);
      const double elevation = radians_from_degrees(elevation_deg);
      const Hrir hrir =
          hrtf.interpolated({std::cos(elevation) * std::cos(azimuth),
                             std::cos(elevation) * std::sin(azimuth), std::sin(elevation)});
      StereoCheck check(kRate);
      check.add(two_ears(convolve(sound, hrir.taps[0]), convolve(sound, hrir.taps[1])));
      const bool is_middle = azimuth_deg == 0 || azimuth_deg == -180;
      // In the middle both ears get the same sound, which cannot be told from mono.
      if (is_middle && check.kind() == StereoKind::same) continue;
      EXPECT_EQ(name_of(check.kind()), "plausible") << azimuth_deg << " " << elevation_deg;
    }
  }
}

TEST(SourceStream, SeparatesTrackedNoiseInWindowsAsOfTheWholeSound) {
  Waveform sound = two_ears(syllables(), syllables());
  RandomStream random(6);
  for (float& x : sound.planar()) x += static_cast<float>(0.01 * random.normal());
  SoundSurvey survey;
  survey.sample_rate_hz = kRate;
  survey.samples = sound.samples();
  for (const AmbientSeparation kind : {AmbientSeparation::subtract, AmbientSeparation::mmse}) {
    const Waveform primary = suppress_noise(sound, kind, 80.0);
    SourceStream stream(read_blocks(sound), survey, kRate, {kind, 80.0});
    constexpr std::ptrdiff_t kSamples = 5000;
    constexpr std::ptrdiff_t kContext = 300;
    for (std::ptrdiff_t start = 0; start < sound.samples(); start += kSamples - 1000) {
      const SourceStream::Window window = stream.window(start, kSamples, kContext);
      for (int ear = 0; ear < 2; ++ear) {
        for (std::ptrdiff_t i = 0; i < kSamples && start + i < sound.samples(); ++i) {
          ASSERT_EQ(window.primary.channel(ear)[kContext + i], primary.channel(ear)[start + i]);
          // Their sum is the recording, up to the rounding of one float sum of values below 1.
          ASSERT_NEAR(window.primary.channel(ear)[kContext + i] + window.ambient.channel(ear)[i],
                      sound.channel(ear)[start + i], 1e-7);
        }
        for (std::ptrdiff_t i = 0; i < kContext && start > 0; ++i) {
          ASSERT_EQ(window.primary.channel(ear)[i], primary.channel(ear)[start - kContext + i]);
        }
      }
    }
  }
}

}  // namespace
}  // namespace earpoint
