// What the native library's stream makes of a clip along a walk, written for the tests of the
// WebAssembly one: the sound and the picture that go in, the earpoint of every block, and the sound
// that comes out.
//
// usage: engine_reference MODEL EARPOINTS.json WALK.csv RATE_HZ FOLDER
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <earpoint/audio/resample.h>
#include <earpoint/error.h>
#include <earpoint/image.h>
#include <earpoint/media/media.h>
#include <earpoint/pose.h>
#include <earpoint/render/dsp_stream.h>
#include <earpoint/render/head_file.h>
#include <earpoint/renderer.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/stream.h>
#include <earpoint/synthesis/earpoint_path.h>
#include <earpoint/waveform.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr std::ptrdiff_t kLongest_s = 60;  // what a clip may last; the rest is left out
constexpr std::ptrdiff_t kBlock = 128;     // of the browsers' audio worklets

template <typename T>
void write(const fs::path& path, std::span<const T> values) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(values.data()),
             static_cast<std::streamsize>(values.size_bytes()));
  if (!file) throw InputError(path.string(), "could not be written");
}

/// The clip's sound at a rate, cut to whole blocks: [2][samples].
Waveform sound_of(const std::string& clip, int rate_hz) {
  AudioReader reader(clip);
  const Waveform whole = resample(reader.read(kLongest_s * reader.sample_rate_hz()), rate_hz);
  Waveform sound(2, whole.samples() / kBlock * kBlock, rate_hz);
  for (int ear = 0; ear < 2; ++ear) {
    std::copy_n(whole.channel(ear).begin(), sound.samples(), sound.channel(ear).begin());
  }
  return sound;
}

/// Position and angles in degrees as an AudioParam holds them: in single precision.
using Place = std::array<float, 6>;

Place place_of(const Pose& pose) {
  const EulerAngles angles = euler_from_quaternion(pose.orientation);
  const auto degrees = [](double radians) {
    return static_cast<float>(degrees_from_radians(radians));
  };
  return {static_cast<float>(pose.position_m.x),
          static_cast<float>(pose.position_m.y),
          static_cast<float>(pose.position_m.z),
          degrees(angles.yaw_rad),
          degrees(angles.pitch_rad),
          degrees(angles.roll_rad)};
}

Pose pose_of(const Place& place) {
  return {{place[0], place[1], place[2]},
          quaternion_from_euler({radians_from_degrees(place[3]), radians_from_degrees(place[4]),
                                 radians_from_degrees(place[5])})};
}

/// A native stream of either kind, as this program needs it.
struct NativeStream {
  std::function<void(const Pose&)> move_to;
  std::function<void(float* left, float* right)> process_block;
  std::ptrdiff_t latency_samples = 0;
};

/// The public library's stream for a network, the signal-processing one for a head file.
NativeStream open_stream(const fs::path& model, int rate_hz, const Vector3& mouth_m,
                         const Image& picture, const Box& box) {
  const SafetensorsFile file = read_safetensors(model);
  if (is_head_file(file)) {
    const SofaFile head = read_head_file(file, model.string());
    const auto stream = std::make_shared<DspStream>(HrtfSet(head, rate_hz), DspStream::Options{});
    stream->place_speaker(mouth_m);
    stream->see(&picture, box);
    return {[stream](const Pose& pose) { stream->move_to(pose); },
            [stream](float* left, float* right) {
              stream->process(
                  {std::span<const float>(left, kBlock), std::span<const float>(right, kBlock)},
                  {std::span(left, kBlock), std::span(right, kBlock)});
            },
            stream->latency_samples()};
  }
  const auto stream =
      std::make_shared<Stream>(Renderer::open(model.string()).stream({.sample_rate_hz = rate_hz}));
  stream->place_speaker(mouth_m);
  stream->see(picture, box);
  return {[stream](const Pose& pose) { stream->move_to(pose); },
          [stream](float* left, float* right) {
            const std::array<float*, 2> ears{left, right};
            stream->process(ears.data(), ears.data(), kBlock);
          },
          stream->latency_samples()};
}

/// @param known_path  a clip and its speaker, as examples/earpoints.json has them
void run(const std::string& model, const fs::path& known_path, const std::string& walk, int rate_hz,
         const fs::path& folder) {
  const nlohmann::json known = nlohmann::json::parse(std::ifstream(known_path));
  const std::string clip = known_path.parent_path() / known.at("clip").get<std::string>();
  const auto mouth_m = known.at("speaker").get<std::array<double, 3>>();
  const auto box = known.at("speaker_box").get<std::array<double, 4>>();
  const Waveform sound = sound_of(clip, rate_hz);
  const Image picture = FrameReader(clip).frame_nearest(0.0);
  const EarpointPath path = EarpointPath::from_csv(walk);

  const NativeStream stream = open_stream(model, rate_hz, {mouth_m[0], mouth_m[1], mouth_m[2]},
                                          picture, {box[0], box[1], box[2], box[3]});
  Waveform heard = sound;
  std::vector<float> places;
  for (std::ptrdiff_t start = 0; start < sound.samples(); start += kBlock) {
    const Place place = place_of(path.at(static_cast<double>(start) / rate_hz));
    places.insert(places.end(), place.begin(), place.end());
    stream.move_to(pose_of(place));
    stream.process_block(heard.channel(0).data() + start, heard.channel(1).data() + start);
  }

  fs::create_directories(folder);
  write<float>(folder / "sound.f32", sound.planar());
  write<float>(folder / "heard.f32", heard.planar());
  write<float>(folder / "places.f32", places);
  write<std::uint8_t>(folder / "picture.rgb", picture.pixels());
  const nlohmann::json about = {{"model", fs::path(model).filename()},
                                {"sampleRate", rate_hz},
                                {"samples", sound.samples()},
                                {"block", kBlock},
                                {"latency", stream.latency_samples},
                                {"width", picture.width()},
                                {"height", picture.height()},
                                {"speaker", mouth_m},
                                {"speakerBox", box}};
  std::ofstream(folder / "about.json") << about.dump(2) << '\n';
}

}  // namespace
}  // namespace earpoint

int main(int argc, char** argv) {
  if (argc != 6) {
    std::fputs("usage: engine_reference MODEL EARPOINTS.json WALK.csv RATE_HZ FOLDER\n", stderr);
    return 2;
  }
  try {
    earpoint::run(argv[1], argv[2], argv[3], std::stoi(argv[4]), argv[5]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "engine_reference: %s\n", error.what());
    return 1;
  }
}
