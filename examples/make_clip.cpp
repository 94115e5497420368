// Makes the clip that the demo and the README use: a recorded voice in a living room, seen by a
// camera with two ears. Everything but the voice is made here: the room, its picture, its sound.
//
// usage: earpoint_make_clip VOICE.wav FOLDER
//
// Writes FOLDER/clip.mp4 (what the camera saw and heard) and FOLDER/truth-*.flac (what the same
// moment sounds like at the demo's earpoints).

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/resample.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/camera/scene_renderer.h>
#include <earpoint/core/error.h>
#include <earpoint/core/parallel.h>
#include <earpoint/scene/material_table.h>
#include <earpoint/scene/scene_builder.h>
#include <earpoint/scene/texture.h>
#include <earpoint/spatial/arrival_renderer.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/spatial/shoebox.h>
#include <earpoint/video/movie_writer.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr int kRate_hz = 48000;
constexpr double kStart_s = 0.9;  // the recording begins with silence
constexpr double kLength_s = 6.0;
constexpr double kResponse_s = 0.7;
constexpr double kPeak = 0.4;
constexpr double kFrameRate_hz = 25.0;
constexpr int kWidth = 640;
constexpr int kHeight = 360;
constexpr double kFov_rad = radians_from_degrees(90.0);

const Vector3 kRoom_m{5.6, 4.4, 2.6};
const Vector3 kMouth_m{3.3, 2.7, 1.5};
const Pose kWorldFromCamera{{1.1, 2.2, 1.5}, {}};

struct Earpoint {
  const char* name;
  Pose source_from_target;
};

/// The demo's three earpoints, in the camera's frame.
std::array<Earpoint, 3> earpoints() {
  return {{{"near", {{1.4, 0.3, 0.0}, {}}},
           {"far-side",
            {{3.6, -1.2, 0.0}, quaternion_from_euler({.yaw_rad = radians_from_degrees(120.0)})}},
           {"turned", {{0.0, 0.0, 0.0}, quaternion_from_euler({.yaw_rad = kPi / 2})}}}};
}

Surface textured(SceneBuilder& builder, const std::string& key, const char* material,
                 TexturePattern pattern, const ScreenColour& colour) {
  Material surface;
  surface.acoustic = standard_material(material);
  surface.look.base_colour = {1.0F, 1.0F, 1.0F};
  surface.look.texture = builder.add_texture(make_texture(pattern, colour, 7));
  return builder.add_surface(key, surface, texture_span_m(pattern));
}

Surface plain(SceneBuilder& builder, const std::string& key, const ScreenColour& colour) {
  Material surface;
  surface.acoustic = standard_material("upholstery_fabric");
  surface.look.base_colour = linear_colour(colour);
  return builder.add_surface(key, surface);
}

void add_shell(SceneBuilder& builder) {
  builder.begin_instance("room", InstanceKind::structure);
  const Vector3& r = kRoom_m;
  const Surface wall =
      textured(builder, "wall", "plaster", TexturePattern::plaster, {0.86F, 0.83F, 0.76F});
  const Surface ceiling =
      textured(builder, "ceiling", "plaster", TexturePattern::plaster, {0.95F, 0.95F, 0.93F});
  const Surface floor =
      textured(builder, "floor", "wood_floor", TexturePattern::wood_planks, {0.55F, 0.38F, 0.24F});
  builder.add_quad({{{0, 0, 0}, {r.x, 0, 0}, {r.x, r.y, 0}, {0, r.y, 0}}}, floor);
  builder.add_quad({{{0, 0, r.z}, {0, r.y, r.z}, {r.x, r.y, r.z}, {r.x, 0, r.z}}}, ceiling);
  builder.add_quad({{{0, 0, 0}, {0, r.y, 0}, {0, r.y, r.z}, {0, 0, r.z}}}, wall);
  builder.add_quad({{{r.x, r.y, 0}, {r.x, 0, 0}, {r.x, 0, r.z}, {r.x, r.y, r.z}}}, wall);
  builder.add_quad({{{r.x, 0, 0}, {0, 0, 0}, {0, 0, r.z}, {r.x, 0, r.z}}}, wall);
  builder.add_quad({{{0, r.y, 0}, {r.x, r.y, 0}, {r.x, r.y, r.z}, {0, r.y, r.z}}}, wall);
}

void add_furniture(SceneBuilder& builder) {
  const Surface carpet =
      textured(builder, "carpet", "carpet_felt", TexturePattern::rug, {0.55F, 0.22F, 0.20F});
  builder.begin_instance("rug", InstanceKind::furniture);
  builder.add_quad({{{2.0, 1.2, 0.01}, {4.4, 1.2, 0.01}, {4.4, 3.0, 0.01}, {2.0, 3.0, 0.01}}},
                   carpet, {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}});

  const Surface cloth = textured(builder, "cloth", "upholstery_fabric", TexturePattern::fabric,
                                 {0.28F, 0.40F, 0.50F});
  builder.begin_instance("sofa", InstanceKind::furniture);
  builder.add_box({4.6, 0.5, 0.1}, {5.5, 2.5, 0.45}, cloth);
  builder.add_box({5.25, 0.5, 0.45}, {5.5, 2.5, 0.85}, cloth);
  builder.add_box({4.6, 0.35, 0.1}, {5.5, 0.55, 0.62}, cloth);
  builder.add_box({4.6, 2.45, 0.1}, {5.5, 2.65, 0.62}, cloth);

  const Surface shelf =
      textured(builder, "books", "furniture_wood", TexturePattern::books, {0.5F, 0.35F, 0.25F});
  builder.begin_instance("shelf", InstanceKind::furniture);
  builder.add_box({3.6, 4.1, 0.0}, {5.3, 4.4, 1.9}, shelf);

  const Surface painting =
      textured(builder, "painting", "furniture_wood", TexturePattern::painting, {0.4F, 0.5F, 0.6F});
  builder.begin_instance("painting", InstanceKind::furniture);
  builder.add_quad({{{5.58, 2.0, 1.3}, {5.58, 1.0, 1.3}, {5.58, 1.0, 2.0}, {5.58, 2.0, 2.0}}},
                   painting, {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}});
}

/// A figure of simple shapes whose mouth is at kMouth_m, facing the camera.
void add_speaker(SceneBuilder& builder) {
  builder.begin_instance("speaker", InstanceKind::person,
                         {.position_m = {kMouth_m.x + 0.1, kMouth_m.y, 0.0}, .yaw_rad = kPi});
  const Surface skin = plain(builder, "skin", {0.80F, 0.60F, 0.50F});
  const Surface shirt = plain(builder, "shirt", {0.75F, 0.30F, 0.22F});
  const Surface trousers = plain(builder, "trousers", {0.20F, 0.22F, 0.30F});
  const Surface hair = plain(builder, "hair", {0.18F, 0.12F, 0.08F});
  constexpr int kSides = 24;
  for (const double side : {-0.10, 0.10}) {
    builder.add_cylinder({0, side, 0}, 0.07, 0.09, 0.80, kSides, trousers);
  }
  builder.add_cylinder({0, 0, 0.78}, 0.17, 0.15, 0.20, kSides, shirt);
  builder.add_cylinder({0, 0, 0.98}, 0.15, 0.20, 0.30, kSides, shirt);
  builder.add_cylinder({0, 0, 1.28}, 0.20, 0.06, 0.08, kSides, shirt);
  for (const double side : {-0.23, 0.23}) {
    builder.add_cylinder({0, side, 0.75}, 0.04, 0.055, 0.58, kSides, shirt);
  }
  builder.add_cylinder({0, 0, 1.36}, 0.055, 0.055, 0.06, kSides, skin);
  builder.add_cylinder({0, 0, 1.42}, 0.06, 0.095, 0.10, kSides, skin);
  builder.add_cylinder({0, 0, 1.52}, 0.095, 0.095, 0.06, kSides, skin);
  builder.add_cylinder({0, 0, 1.58}, 0.10, 0.08, 0.07, kSides, hair);
  builder.add_cylinder({0, 0, 1.65}, 0.08, 0.0, 0.04, kSides, hair);
}

Image picture() {
  SceneBuilder builder;
  add_shell(builder);
  add_furniture(builder);
  add_speaker(builder);
  builder.add_lamp(
      {.position_m = {2.8, 2.2, 2.35}, .intensity = {9.0F, 8.2F, 7.0F}, .radius_m = 0.15F});
  const SceneRenderer renderer(builder.take());
  const Camera camera{kWorldFromCamera, kFov_rad, kWidth, kHeight};
  RenderQuality quality;
  quality.samples_per_side = 6;
  ThreadPool pool(available_cores());
  return renderer.render(camera, quality, 1, pool).rgb;
}

/// The room as sound sees it: an empty box whose walls share out the furniture's absorption.
Shoebox room() {
  Shoebox box{.lengths_m = kRoom_m};
  const std::array<const char*, 6> faces = {"plasterboard_wall", "curtain_light",
                                            "plasterboard_wall", "furniture_wood",
                                            "carpet_felt",       "plasterboard_ceiling"};
  std::transform(faces.begin(), faces.end(), box.absorption.begin(),
                 [](const char* name) { return standard_material(name).absorption; });
  return box;
}

Waveform heard_at(const Pose& world_from_listener, const Waveform& voice, const HrtfSet& hrtf) {
  const auto arrivals = shoebox_arrivals(room(), kMouth_m, world_from_listener, kResponse_s);
  const Waveform response = render_arrivals(arrivals, hrtf, kResponse_s);
  Waveform sound(2, voice.samples(), kRate_hz);
  for (int ear = 0; ear < 2; ++ear) {
    const std::vector<float> convolved = convolve(voice.channel(0), response.channel(ear));
    std::copy_n(convolved.begin(), sound.samples(), sound.channel(ear).begin());
  }
  return sound;
}

/// The voice at the clip's rate and length, its last tenth of a second faded out.
Waveform read_voice(const fs::path& path) {
  const Waveform recorded = resample(read_sound(path), kRate_hz);
  if (recorded.channels() != 1 || recorded.duration_s() < kStart_s + kLength_s) {
    throw InputError(path.string(), "expected at least 7 s of mono sound");
  }
  Waveform voice(1, std::lround(kLength_s * kRate_hz), kRate_hz);
  std::copy_n(recorded.channel(0).begin() + std::lround(kStart_s * kRate_hz), voice.samples(),
              voice.channel(0).begin());
  const std::ptrdiff_t fade = kRate_hz / 10;
  for (std::ptrdiff_t i = 0; i < fade; ++i) {
    voice.channel(0)[voice.samples() - 1 - i] *= static_cast<float>(i) / static_cast<float>(fade);
  }
  return voice;
}

void scale(Waveform& sound, float gain) {
  for (float& sample : sound.planar()) sample *= gain;
}

void make_clip(const fs::path& voice_path, const fs::path& folder) {
  const Waveform voice = read_voice(voice_path);
  const HrtfSet hrtf = HrtfSet::load(kRate_hz);
  Waveform source = heard_at(kWorldFromCamera, voice, hrtf);
  const auto samples = source.planar();
  const float peak = std::abs(*std::max_element(
      samples.begin(), samples.end(), [](float a, float b) { return std::abs(a) < std::abs(b); }));
  const float gain = static_cast<float>(kPeak) / peak;
  scale(source, gain);

  MovieWriter movie(folder / "clip.mp4", kWidth, kHeight, kFrameRate_hz, kRate_hz);
  const Image image = picture();
  for (int i = 0; i < static_cast<int>(kLength_s * kFrameRate_hz); ++i) movie.write_picture(image);
  movie.write_sound(source);
  movie.close();

  for (const Earpoint& earpoint : earpoints()) {
    Waveform truth = heard_at(kWorldFromCamera * earpoint.source_from_target, voice, hrtf);
    scale(truth, gain);
    write_sound(folder / (std::string("truth-") + earpoint.name + ".flac"), truth,
                SampleFormat::pcm16);
  }
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
