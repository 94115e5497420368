#include "faint_speech.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/resample.h>
#include <earpoint/audio/window_of.h>
#include <earpoint/dataset/ambient.h>

namespace earpoint {
namespace {

constexpr double kFaintest_db = -60.0;
constexpr double kFewestBursts = 1.0;  // a second
constexpr double kMostBursts = 30.0;
constexpr double kShortestBurst_s = 0.0002;
constexpr double kLongestBurst_s = 0.1;

constexpr int kRatesHz[] = {6000, 8000, 11025, 14000, 16000, 32000, 48000};

/// A number between two, evenly spread on a logarithmic scale.
double between(double least, double most, RandomStream& random) {
  return least * std::pow(most / least, random.uniform());
}

/// Lets noise be heard in bursts that begin at random moments and decay, as loud in the mean.
void burst(Waveform& noise, double level_db, RandomStream& random) {
  const double rate = noise.sample_rate_hz();
  const double begins = between(kFewestBursts, kMostBursts, random) / rate;
  const double kept = std::exp(-1.0 / (rate * between(kShortestBurst_s, kLongestBurst_s, random)));
  double size = 1.0;
  for (std::ptrdiff_t i = 0; i < noise.samples(); ++i) {
    for (int channel = 0; channel < noise.channels(); ++channel) {
      noise.channel(channel)[i] *= static_cast<float>(size);
    }
    size = random.uniform() < begins ? 1.0 : kept * size;
  }
  const double found = energy(noise.planar()) / static_cast<double>(noise.planar().size());
  if (found <= 0.0) return;
  const auto gain = static_cast<float>(std::sqrt(std::pow(10.0, level_db / 10.0) / found));
  for (float& value : noise.planar()) value *= gain;
}

/// Noise as devices of several rates record it: its spectrum does not always end where that of
/// the samples does. @return as long as the sound and of its rate
Waveform noise_like(const Waveform& sound, int channels, double level_db, RandomStream& random) {
  const int rate = kRatesHz[random.index(std::size(kRatesHz))];
  const double corner_hz = between(kRoomNoiseCornerHz, 0.5 * rate, random);
  const std::ptrdiff_t samples = 1 + sound.samples() * rate / sound.sample_rate_hz();
  Waveform noise(channels, samples, rate);
  add_room_noise(noise, level_db, random, 0, corner_hz);
  return window_of(resample(noise, sound.sample_rate_hz()), 0, sound.samples());
}

/// Adds two channels of the noise, from `first` on.
void add_ears(Waveform& sound, const Waveform& noise, int first) {
  for (int ear = 0; ear < 2; ++ear) {
    std::ranges::transform(sound.channel(ear), noise.channel(first + ear),
                           sound.channel(ear).begin(), std::plus<>());
  }
}

}  // namespace

void make_faint(PairSample& sample, PairTarget target, double noise_db, RandomStream& random) {
  const auto gain = static_cast<float>(std::pow(10.0, random.uniform(kFaintest_db, 0.0) / 20.0));
  for (Waveform* speech : {&sample.source, &sample.target, &sample.dry}) {
    for (float& value : speech->planar()) value *= gain;
  }
  const bool at_target = target == PairTarget::viewpoint;
  Waveform noise = noise_like(sample.source, at_target ? 4 : 2, noise_db, random);
  if (random.index(2) == 1) {
    for (int left = 0; left < noise.channels(); left += 2) {
      std::ranges::copy(noise.channel(left), noise.channel(left + 1).begin());
    }
  }
  if (random.index(2) == 1) burst(noise, noise_db, random);
  add_ears(sample.source, noise, 0);
  if (at_target) add_ears(sample.target, noise, 2);
}

}  // namespace earpoint
