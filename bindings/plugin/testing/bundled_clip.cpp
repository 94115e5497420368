#include "bundled_clip.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/temporary_folder.h>
#include <earpoint/renderer.h>

namespace earpoint::plugin {

namespace fs = std::filesystem;

const Waveform& bundled_clip() {
  static const Waveform sound = [] {
    const TemporaryFolder folder;
    const fs::path wav = folder.path() / "clip.wav";
    run_command("ffmpeg -v error -i '" EARPOINT_SOURCE_DIR
                "/examples/clip.mp4' -vn -c:a pcm_f32le " +
                wav.string());
    return read_sound(wav);
  }();
  return sound;
}

Settings bundled_settings() {
  return {.earpoint = {{1.49F, -0.2F, 0.0F},
                       quaternion_from_euler({.yaw_rad = radians_from_degrees(-45.0)})},
          .speaker_m = Vector3{1.89F, 0.196F, 0.147F}};
}

Waveform stream_of_library(const std::string& model, const Settings& settings,
                           const Waveform& sound) {
  Stream stream = Renderer::open(model).stream({.sample_rate_hz = sound.sample_rate_hz()});
  stream.move_to(settings.earpoint);
  stream.place_speaker(settings.speaker_m);
  Waveform result(2, sound.samples(), sound.sample_rate_hz());
  const float* const in[] = {sound.channel(0).data(), sound.channel(1).data()};
  float* const out[] = {result.channel(0).data(), result.channel(1).data()};
  stream.process(in, out, sound.samples());
  return result;
}

std::string run_command(const std::string& command) {
  std::FILE* const pipe = ::popen(("(" + command + ") 2>&1").c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  std::string text;
  std::array<char, 4096> part{};
  while (const std::size_t count = std::fread(part.data(), 1, part.size(), pipe)) {
    text.append(part.data(), count);
  }
  if (::pclose(pipe) != 0) throw std::runtime_error(command + "\n" + text);
  return text;
}

std::string find_program(const std::string& name) {
  std::istringstream folders(std::getenv("PATH"));
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path path = fs::path(folder) / name;
    if (fs::is_regular_file(path)) return path.string();
  }
  return {};
}

Waveform part_of(const Waveform& sound, std::ptrdiff_t start, std::ptrdiff_t samples) {
  Waveform part(2, samples, sound.sample_rate_hz());
  for (int c = 0; c < 2; ++c) {
    std::copy_n(sound.channel(c).begin() + start, samples, part.channel(c).begin());
  }
  return part;
}

bool same(const Waveform& a, const Waveform& b) {
  return std::ranges::equal(a.planar(), b.planar());
}

Waveform delayed(const Waveform& sound, std::ptrdiff_t samples) {
  Waveform late(2, sound.samples(), sound.sample_rate_hz());
  for (int c = 0; c < 2; ++c) {
    std::copy_n(sound.channel(c).begin(), sound.samples() - samples,
                late.channel(c).begin() + samples);
  }
  return late;
}

}  // namespace earpoint::plugin
