#include <algorithm>
#include <array>
#include <cstring>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/media/image_file.h>
#include <earpoint/plot/draw.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr std::ptrdiff_t kSamples = 16000;
constexpr std::ptrdiff_t kLater = 20;

/// A table of 1 x 5 numbers as NumPy writes it.
std::string npy(const std::array<double, 5>& row) {
  std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 5), }";
  header.resize(117, ' ');
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00\x76\x00", 10);
  bytes += header;
  const std::size_t begin = bytes.size();
  bytes.resize(begin + sizeof(row));
  std::memcpy(bytes.data() + begin, row.data(), sizeof(row));
  return bytes;
}

void write_camera(const fs::path& stem, const Waveform& heard) {
  write_sound(stem.string() + ".wav", heard, SampleFormat::float32);
  write_image(stem.string() + ".png", filled_image(64, 36, {200, 10, 30}));
  write_file(stem.string() + ".npy", std::string_view(npy({0.125, 0.25, 0.5, 0.75, 3.0})));
}

}  // namespace

void write_tiny_replay_dataset(const fs::path& folder, const std::vector<std::string>& clips) {
  const fs::path published = "data/appen_dataset/v3";
  RandomStream random(1);
  nlohmann::ordered_json metadata;
  nlohmann::ordered_json cameras;
  for (const std::string& clip : clips) {
    fs::create_directories(folder / published / clip);
    Waveform sound(2, kSamples + kLater, 16000);
    for (float& x : sound.planar()) x = static_cast<float>(0.1 * random.normal());
    for (int camera = 1; camera <= 2; ++camera) {
      Waveform heard(2, kSamples, 16000);
      for (int ear = 0; ear < 2; ++ear) {
        std::copy_n(sound.channel(ear).begin() + (camera == 1 ? kLater : 0), kSamples,
                    heard.channel(ear).begin());
      }
      write_camera(folder / published / clip / fmt::format("{}", camera), heard);
    }
    metadata[(published / clip).string()] = {"1.png", "2.png"};
    const std::string scene = fs::path(clip).parent_path().string();
    cameras["centers"][scene] = {{"DSLR-1", {100, 0, 150}}, {"DSLR-2", {200, 200, 150}}};
    cameras["rotations"][scene] = {{"DSLR-1", {1, 0, 0}}, {"DSLR-2", {0, 1, 0}}};
  }
  write_file(folder / published / "metadata_v2.json", std::string_view(metadata.dump()));
  write_file(folder / published.parent_path() / "camera_positions_fixed_rotation.json",
             std::string_view(cameras.dump()));
}

}  // namespace earpoint
