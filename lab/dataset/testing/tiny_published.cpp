#include <earpoint/dataset_testing/tiny_published.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/media/image_file.h>
#include <earpoint/plot/draw.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr int kRwavsRate = 22050;
constexpr int kRwavsSeconds = 8;
constexpr int kRafRate = 48000;
constexpr Vector3 kSpeaker{0.1, 0.2, 0.3};

/// Where the head of a second is on its circle, and whether it looks along -x.
struct Stand {
  Vector3 at;
  bool turned = false;
};

Stand stand_of(int second, double radius) {
  const double angle = 0.7 * second;
  return {kSpeaker + Vector3{radius * std::cos(angle), radius * std::sin(angle), 0.0},
          second % 2 == 0};
}

bool speaker_is_left(const Stand& stand) { return (kSpeaker.y > stand.at.y) != stand.turned; }

nlohmann::json pose_of(int second, const Stand& stand) {
  // Columns of a camera that looks along x: right is -y, up is z, back is -x.
  const double s = stand.turned ? -1.0 : 1.0;
  return {{"file_path", fmt::format("frames/{:05}.png", second)},
          {"camera_to_world",
           {0, 0, -s, stand.at.x, -s, 0, 0, stand.at.y, 0, 1, 0, stand.at.z, 0, 0, 0, 1}}};
}

void write_scene(const fs::path& folder, std::uint64_t seed, double radius, float loudness) {
  fs::create_directories(folder / "frames");
  RandomStream random(seed);
  Waveform dry(1, static_cast<std::ptrdiff_t>(8.4 * kRwavsRate), kRwavsRate);
  Waveform heard(2, dry.samples(), kRwavsRate);
  for (std::ptrdiff_t n = 0; n < dry.samples(); ++n) {
    const double pulse = std::pow(std::sin(kPi * static_cast<double>(n) / 4000.0), 2);
    const auto x = static_cast<float>(0.1 * pulse * random.normal());
    dry.channel(0)[n] = x;
    const auto second = static_cast<int>(std::lround(static_cast<double>(n) / kRwavsRate));
    const int louder = speaker_is_left(stand_of(second, radius)) ? 0 : 1;
    heard.channel(louder)[n] = loudness * x;
    heard.channel(1 - louder)[n] = 0.5F * loudness * x;
  }
  write_sound(folder / "source_syn_re.wav", dry, SampleFormat::pcm16);
  write_sound(folder / "binaural_syn_re.wav", heard, SampleFormat::pcm16);
  nlohmann::json train;
  nlohmann::json val;
  for (int second = 1; second <= kRwavsSeconds; ++second) {
    write_image(folder / "frames" / fmt::format("{:05}.png", second),
                filled_image(8, 6, {90, 90, 90}));
    (second % 4 == 0 ? val : train)["camera_path"].push_back(
        pose_of(second, stand_of(second, radius)));
  }
  for (const char* name : {"transforms_scale_{}.json", "transforms_{}.json"}) {
    write_file(folder / fmt::format(fmt::runtime(name), "train"), std::string_view(train.dump()));
    write_file(folder / fmt::format(fmt::runtime(name), "val"), std::string_view(val.dump()));
  }
}

}  // namespace

void write_tiny_rwavs(const fs::path& folder) {
  nlohmann::json positions;
  for (const char* scene : {"1", "2"}) {
    const bool first = std::string(scene) == "1";
    write_scene(folder / scene, first ? 1 : 2, first ? 0.4 : 0.2, first ? 0.6F : 0.3F);
    positions[scene]["source_position"] = {kSpeaker.x, kSpeaker.y, kSpeaker.z};
  }
  write_file(folder / "position.json", std::string_view(positions.dump()));
}

void write_tiny_raf(const fs::path& folder) {
  fs::create_directories(folder / "metadata");
  std::string receivers;
  std::string speakers;
  nlohmann::json split{{"train", {nlohmann::json::array()}},
                       {"validation", nlohmann::json::array()},
                       {"test", {nlohmann::json::array()}}};
  for (int i = 0; i < 8; ++i) {
    const std::string id = fmt::format("{:06}", i);
    const fs::path item = folder / "data" / id;
    fs::create_directories(item);
    RandomStream random(7, {static_cast<std::uint64_t>(i)});
    Waveform response(1, static_cast<std::ptrdiff_t>(0.4 * kRafRate), kRafRate);
    const double t60_s = 0.3 + 0.02 * i;
    for (std::ptrdiff_t n = 0; n < response.samples(); ++n) {
      const double fall = std::pow(10.0, -3.0 * static_cast<double>(n) / kRafRate / t60_s);
      response.channel(0)[n] = static_cast<float>(0.1 * fall * random.normal());
    }
    write_sound(item / "rir.wav", response, SampleFormat::float32);
    // y is up; without a turn the loudspeaker faces along -z.
    const std::string receiver = fmt::format("{},1.5,0\n", 0.5 * i);
    const std::string speaker = "0,0,0,1,0,1,2\n";
    write_file(item / "rx_pos.txt", std::string_view(receiver));
    write_file(item / "tx_pos.txt", std::string_view(speaker));
    receivers += receiver;
    speakers += speaker;
    // Published lists hold the folders flat or in a list of one.
    if (i % 2 == 0) {
      split["train"][0].push_back(id);
    } else if (i < 4) {
      split["validation"].push_back(id);
    } else {
      split["test"][0].push_back(id);
    }
  }
  write_file(folder / "metadata" / "all_rx_pos.txt", std::string_view(receivers));
  write_file(folder / "metadata" / "all_tx_pos.txt", std::string_view(speakers));
  write_file(folder / "metadata" / "data-split.json", std::string_view(split.dump()));
}

}  // namespace earpoint
