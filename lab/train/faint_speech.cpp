#include "faint_speech.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
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
    for (int ear = 0; ear < noise.channels(); ++ear) {
      noise.channel(ear)[i] *= static_cast<float>(size);
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
Waveform noise_like(const Waveform& sound, double level_db, RandomStream& random) {
  const int rate = kRatesHz[random.index(std::size(kRatesHz))];
  const double corner_hz = between(kRoomNoiseCornerHz, 0.5 * rate, random);
  const std::ptrdiff_t samples = 1 + sound.samples() * rate / sound.sample_rate_hz();
  Waveform noise(sound.channels(), samples, rate);
  add_room_noise(noise, level_db, random, 0, corner_hz);
  return window_of(resample(noise, sound.sample_rate_hz()), 0, sound.samples());
}

}  // namespace

void make_faint(PairSample& sample, double noise_db, RandomStream& random) {
  const auto gain = static_cast<float>(std::pow(10.0, random.uniform(kFaintest_db, 0.0) / 20.0));
  for (Waveform* speech : {&sample.source, &sample.target, &sample.dry}) {
    for (float& value : speech->planar()) value *= gain;
  }
  Waveform noise = noise_like(sample.source, noise_db, random);
  if (random.index(2) == 1) std::ranges::copy(noise.channel(0), noise.channel(1).begin());
  if (random.index(2) == 1) burst(noise, noise_db, random);
  for (std::size_t i = 0; i < noise.planar().size(); ++i) {
    sample.source.planar()[i] += noise.planar()[i];
  }
}

}  // namespace earpoint
