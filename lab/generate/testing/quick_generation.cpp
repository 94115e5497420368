#include <earpoint/generate_testing/quick_generation.h>

#include <cmath>

#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/random.h>
#include <earpoint/pose.h>
#include <earpoint/scene/material_table.h>
#include <earpoint/waveform.h>

namespace earpoint {

namespace fs = std::filesystem;

TestFolder::TestFolder(const std::string& name)
    : path_(fs::temp_directory_path() / (name + "." + std::to_string(::getpid()))) {
  fs::remove_all(path_);
  fs::create_directories(path_);
}
TestFolder::~TestFolder() { fs::remove_all(path_); }

fs::path write_test_corpus(const fs::path& folder) {
  fs::create_directories(folder);
  std::string index = "file,speaker,gender\n";
  for (int voice = 0; voice < 6; ++voice) {
    for (int take = 0; take < 2; ++take) {
      RandomStream random(static_cast<std::uint64_t>(10 * voice + take));
      Waveform sound(1, 19200, 16000);
      for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
        const double syllable =
            std::max(0.0, std::sin(2.0 * kPi * (4.0 + voice) * static_cast<double>(i) / 16000.0));
        sound.channel(0)[i] = static_cast<float>(0.1 * syllable * random.uniform(-1.0, 1.0));
      }
      const std::string name = "voice" + std::to_string(voice) + "_" + std::to_string(take);
      write_sound(folder / (name + ".wav"), sound, SampleFormat::pcm16);
      index +=
          name + ".wav,voice" + std::to_string(voice) + (voice % 2 == 0 ? ",female\n" : ",male\n");
    }
  }
  write_file(folder / "speech.csv", index);
  return folder;
}

GenerationOptions quick_options(const fs::path& folder) {
  GenerationOptions options;
  options.folder = folder;
  options.quality.rays = 200;
  options.quality.duration_s = 0.3;
  options.quality.image_width = 64;
  options.quality.image_height = 64;
  options.quality.samples_per_side = 1;
  return options;
}

Scene two_rooms() {
  SceneBuilder builder;
  const auto surface = [&](const char* key, const std::array<float, 3>& colour) {
    Material material;
    material.acoustic = standard_material("plaster");
    material.look.base_colour = colour;
    return builder.add_surface(key, material);
  };
  const Surface wall = surface("wall", {0.7F, 0.7F, 0.65F});
  const Surface floor = surface("floor", {0.4F, 0.3F, 0.2F});
  constexpr double kHeight_m = 2.6;
  builder.begin_instance("shell", InstanceKind::structure);
  const auto room = [&](double x0, double x1) {
    builder.add_quad({Vector3{x0, 0, 0}, {x1, 0, 0}, {x1, 5, 0}, {x0, 5, 0}}, floor);
    builder.add_quad(
        {Vector3{x0, 5, kHeight_m}, {x1, 5, kHeight_m}, {x1, 0, kHeight_m}, {x0, 0, kHeight_m}},
        wall);
    builder.add_quad({Vector3{x0, 0, 0}, {x0, 0, kHeight_m}, {x1, 0, kHeight_m}, {x1, 0, 0}}, wall);
    builder.add_quad({Vector3{x1, 5, 0}, {x1, 5, kHeight_m}, {x0, 5, kHeight_m}, {x0, 5, 0}}, wall);
  };
  room(0, 10);
  builder.add_quad({Vector3{0, 5, 0}, {0, 5, kHeight_m}, {0, 0, kHeight_m}, {0, 0, 0}}, wall);
  builder.add_quad({Vector3{10, 0, 0}, {10, 0, kHeight_m}, {10, 5, kHeight_m}, {10, 5, 0}}, wall);
  builder.begin_instance("wall between", InstanceKind::structure);
  builder.add_box({6.0, 0, 0}, {6.12, 3.0, kHeight_m}, wall);
  builder.add_box({6.0, 4.0, 0}, {6.12, 5.0, kHeight_m}, wall);
  builder.begin_instance("table", InstanceKind::furniture);
  builder.add_box({1.0, 0.2, 0.7}, {2.2, 1.0, 0.75}, floor);
  builder.add_lamp({.position_m = {3, 2.5, 2.4}, .intensity = {10, 10, 9}});
  Scene scene = builder.take();
  check_scene(scene, "two rooms");
  return scene;
}

std::shared_ptr<const PreparedScene> TestScenes::make(int scene) const {
  return prepare_home(name(scene), two_rooms());
}

std::string TestScenes::name(int scene) const { return "rooms-" + std::to_string(scene); }

std::map<std::string, std::string> contents_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    files[entry.path().lexically_relative(folder).generic_string()] = read_text_file(entry.path());
  }
  return files;
}

}  // namespace earpoint
