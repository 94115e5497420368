// Makes the clip that the demo and the README use: a recorded voice in a furnished home, before a
// camera with binaural sound, and the sound at other positions. Everything but the voice is made
// here: the home, its picture, its sound.
//
// usage: earpoint_make_clip VOICE.wav FOLDER
//
// Writes FOLDER/clip.mp4 (the camera's picture and sound), FOLDER/truth-*.flac (the true sound at
// the earpoints), FOLDER/map.jpg (the home from above) and FOLDER/earpoints.json, which describes
// them.

#include "demo_home.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/resample.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>
#include <earpoint/media/movie_writer.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/trace/response_synthesizer.h>
#include <earpoint/trace/tracer.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr int kRate_hz = 48000;
constexpr double kVoice_s = 5.6;  // two sentences of the recording
constexpr double kBefore_s = 0.2;
constexpr double kLength_s = 6.5;  // the rest is the room's decay
constexpr double kResponse_s = 1.0;
constexpr int kRays = 20000;
constexpr double kPeak = 0.5;  // of the loudest earpoint
constexpr double kFrameRate_hz = 25.0;
constexpr std::uint64_t kSeed = 1;

/// The voice at the clip's rate and length.
Waveform read_voice(const fs::path& path) {
  const Waveform recorded = resample(read_sound(path), kRate_hz);
  if (recorded.channels() != 1 || recorded.duration_s() < kVoice_s) {
    throw InputError(path.string(), fmt::format("expected at least {} s of mono sound", kVoice_s));
  }
  Waveform voice(1, std::lround(kLength_s * kRate_hz), kRate_hz);
  std::copy_n(recorded.channel(0).begin(), std::lround(kVoice_s * kRate_hz),
              voice.channel(0).begin() + std::lround(kBefore_s * kRate_hz));
  return voice;
}

/// The sound at poses in the camera's frame; its own pose is the first.
std::vector<Waveform> heard_at(const DemoHome& home, const std::vector<Pose>& places,
                               const Waveform& voice, ThreadPool& pool) {
  const Source mouth{.world_from_source = home.speaker.world_from_head,
                     .directivity = speech_directivity(),
                     .body = home.speaker.instance};
  std::vector<Pose> listeners;
  std::vector<Vector3> positions;
  for (const Pose& place : places) {
    listeners.push_back(home.camera.world_from_camera * place);
    positions.push_back(listeners.back().position_m);
  }
  const TraceResult traced = trace(AcousticScene(home.scene), {&mouth, 1}, positions,
                                   {.rays = kRays, .duration_s = kResponse_s, .seed = kSeed}, pool);
  const ResponseSynthesizer drawer(
      {.sample_rate_hz = kRate_hz, .duration_s = kResponse_s, .seed = kSeed});
  const HrtfSet hrtf = HrtfSet::load(kRate_hz);
  std::vector<Waveform> sounds;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Waveform response =
        drawer.binaural(traced.responses[0][i], listeners[i].orientation, hrtf, i);
    Waveform& sound = sounds.emplace_back(2, voice.samples(), kRate_hz);
    for (int ear = 0; ear < 2; ++ear) {
      const std::vector<float> convolved = convolve(voice.channel(0), response.channel(ear));
      std::copy_n(convolved.begin(), sound.samples(), sound.channel(ear).begin());
    }
  }
  return sounds;
}

/// One gain for all, so that the loudest peak is kPeak.
void level(std::vector<Waveform>& sounds) {
  float peak = 0.0F;
  for (const Waveform& sound : sounds) {
    for (const float sample : sound.planar()) peak = std::max(peak, std::abs(sample));
  }
  const float gain = static_cast<float>(kPeak) / peak;
  for (Waveform& sound : sounds) {
    for (float& sample : sound.planar()) sample *= gain;
  }
}

/// "speaker on the left" becomes "truth-speaker-on-the-left.flac".
std::string truth_file(std::string name) {
  std::ranges::replace(name, ' ', '-');
  return "truth-" + name + ".flac";
}

/// To three decimals.
double rounded(double value) { return std::round(value * 1000.0) / 1000.0; }

std::array<double, 3> rounded(const Vector3& place) {
  return {rounded(place.x), rounded(place.y), rounded(place.z)};
}

void write_description(const fs::path& path, const DemoHome& home,
                       const std::vector<DemoEarpoint>& earpoints, const Box& box,
                       const FloorMapPicture& map) {
  const Pose camera_from_mouth =
      inverse(home.camera.world_from_camera) * home.speaker.world_from_head;
  nlohmann::ordered_json json;
  json["clip"] = "clip.mp4";
  json["speaker"] = rounded(camera_from_mouth.position_m);
  json["speaker_box"] = {rounded(box.x_min), rounded(box.y_min), rounded(box.x_max),
                         rounded(box.y_max)};
  json["map"] = {{"picture", "map.jpg"},
                 {"camera", {std::lround(map.camera.x), std::lround(map.camera.y)}},
                 {"pixels_per_metre", map.pixels_per_metre}};
  for (const DemoEarpoint& earpoint : earpoints) {
    json["earpoints"].push_back({{"name", earpoint.name},
                                 {"translate", rounded(earpoint.source_from_target.position_m)},
                                 {"yaw_deg", earpoint.yaw_deg},
                                 {"truth", truth_file(earpoint.name)}});
  }
  write_file(path, json.dump(2) + "\n");
}

void write_movie(const fs::path& path, const Image& picture, const Waveform& sound) {
  MovieWriter movie(path, picture.width(), picture.height(), kFrameRate_hz, kRate_hz);
  const auto frames = static_cast<int>(kLength_s * kFrameRate_hz);
  for (int i = 0; i < frames; ++i) movie.write_picture(picture);
  movie.write_sound(sound);
  movie.close();
}

void make_clip(const fs::path& voice_path, const fs::path& folder) {
  ThreadPool pool(available_cores());
  const Waveform voice = read_voice(voice_path);
  const DemoHome home = make_demo_home();
  const std::vector<DemoEarpoint> earpoints = demo_earpoints(home);

  const View view =
      SceneDrawer(home.scene, {}, pool).draw(home.camera, {.samples_per_side = 6}, kSeed, pool);
  const auto box = visible_box(view, static_cast<int>(home.speaker.instance), 1);
  EARPOINT_CHECK(box.has_value());
  const FloorMapPicture map = picture_from_above(home, pool);

  std::vector<Pose> places{Pose{}};
  for (const DemoEarpoint& earpoint : earpoints) places.push_back(earpoint.source_from_target);
  std::vector<Waveform> sounds = heard_at(home, places, voice, pool);
  level(sounds);

  write_movie(folder / "clip.mp4", view.rgb, sounds.front());
  for (std::size_t i = 0; i < earpoints.size(); ++i) {
    write_sound(folder / truth_file(earpoints[i].name), sounds[i + 1], SampleFormat::pcm16);
  }
  write_image(folder / "map.jpg", map.rgb);
  write_description(folder / "earpoints.json", home, earpoints, *box, map);
}

}  // namespace
}  // namespace earpoint

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: earpoint_make_clip VOICE.wav FOLDER\n");
    return 2;
  }
  try {
    earpoint::make_clip(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "earpoint_make_clip: %s\n", error.what());
    return 2;
  }
  return 0;
}
