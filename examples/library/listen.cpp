// Renders a sound file at another position: the whole clip at once, then live on the way there, in
// blocks of 256 samples.
//
// usage: listen IN.wav WHOLE.wav LIVE.wav
#include "count_allocations.h"

#include <algorithm>
#include <cstdio>
#include <vector>

#include <sndfile.hh>

#include <earpoint/renderer.h>

namespace {

earpoint::Waveform read(const char* path) {
  SndfileHandle file(path);
  std::vector<float> samples(static_cast<std::size_t>(file.frames() * file.channels()));
  if (file.readf(samples.data(), file.frames()) == 0) throw earpoint::InputError(path, "no sound");
  earpoint::Waveform sound(file.channels(), file.frames(), file.samplerate());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    sound.channel(static_cast<int>(i) % file.channels())[i / file.channels()] = samples[i];
  }
  return sound;
}

void write(const char* path, const earpoint::Waveform& sound) {
  SndfileHandle file(path, SFM_WRITE, SF_FORMAT_WAV | SF_FORMAT_FLOAT, 2, sound.sample_rate_hz());
  for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
    const float both[] = {sound.channel(0)[i], sound.channel(1)[i]};
    file.writef(both, 1);
  }
}

int listen(const char* in_path, const char* whole_path, const char* live_path) {
  const earpoint::Waveform sound = read(in_path);
  const earpoint::Vector3 mouth{1.89, 0.2, 0.15};  // metres in front, to the left, up
  const earpoint::Pose there{{1.0, -0.5, 0.0}, earpoint::quaternion_from_euler({.yaw_rad = 1.57})};

  earpoint::Renderer renderer = earpoint::Renderer::open("gtf");
  write(whole_path, renderer.render(sound, {.speaker_m = mouth, .target = there}));

  earpoint::Stream stream = renderer.stream({.sample_rate_hz = sound.sample_rate_hz()});
  stream.place_speaker(mouth);
  earpoint::Waveform live(2, sound.samples(), sound.sample_rate_hz());
  const long before = allocations();
  for (std::ptrdiff_t at = 0; at < sound.samples(); at += 256) {
    const double way = static_cast<double>(at) / static_cast<double>(sound.samples());
    stream.move_to(
        {{way, -0.5 * way, 0.0}, earpoint::quaternion_from_euler({.yaw_rad = 1.57 * way})});
    const float* in[] = {sound.channel(0).data() + at, sound.channel(1).data() + at};
    float* out[] = {live.channel(0).data() + at, live.channel(1).data() + at};
    stream.process(in, out, std::min<std::ptrdiff_t>(256, sound.samples() - at));
  }
  const long during = allocations() - before;
  write(live_path, live);
  std::printf("latency %td samples, %ld allocations while live\n", stream.latency_samples(),
              during);
  return during == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: listen IN.wav WHOLE.wav LIVE.wav\n");
    return 2;
  }
  try {
    return listen(argv[1], argv[2], argv[3]);
  } catch (const earpoint::InputError& error) {
    std::fprintf(stderr, "listen: %s\n", error.what());
    return 2;
  }
}
