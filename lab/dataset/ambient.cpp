#include <earpoint/dataset/ambient.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <earpoint/dataset/sample.h>
#include <earpoint/pose.h>

namespace earpoint {

void add_room_noise(Waveform& sound, double level_db, RandomStream& random, std::ptrdiff_t context,
                    double corner_hz) {
  const double level = std::pow(10.0, level_db / 20.0);
  // One pole; white noise of this size at its input gives a root mean square of `level`.
  const double pole = std::exp(-2.0 * kPi * corner_hz / sound.sample_rate_hz());
  const double input = level * std::sqrt(1.0 - pole * pole);
  std::vector<double> first;
  for (int ear = 0; ear < sound.channels(); ++ear) {
    double noise = level * random.normal();
    for (float& value : sound.channel(ear).subspan(context)) {
      noise = pole * noise + input * random.normal();
      value += static_cast<float>(noise);
      if (std::ssize(first) == ear) first.push_back(noise);
    }
  }
  // Reversed in time, such noise is the same process.
  for (int ear = 0; ear < sound.channels() && context > 0; ++ear) {
    double noise = first.at(ear);
    const auto before = sound.channel(ear).first(context);
    std::for_each(before.rbegin(), before.rend(), [&](float& value) {
      noise = pole * noise + input * random.normal();
      value += static_cast<float>(noise);
    });
  }
}

void add_ambient(PairSample& sample, double level_db, std::uint64_t seed) {
  RandomStream random(seed);
  add_room_noise(sample.source, level_db, random);
  add_room_noise(sample.target, level_db, random);
}

Waveform primary_sound(const Waveform& sound, AmbientSeparation separation) {
  return separation == AmbientSeparation::bandpass
             ? highpass(sound, kSeparationCutoffHz)
             : suppress_noise(sound, separation, kSeparationCutoffHz);
}

void separate_source(PairSample& sample, AmbientSeparation separation) {
  Waveform primary = primary_sound(sample.source, separation);
  Waveform ambient = std::move(sample.source);
  for (std::size_t i = 0; i < ambient.planar().size(); ++i) {
    ambient.planar()[i] -= primary.planar()[i];
  }
  sample.source = std::move(primary);
  sample.ambient = std::move(ambient);
}

}  // namespace earpoint
