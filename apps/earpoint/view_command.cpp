#include "view_command.h"

#include "flag_advice.h"
#include "flag_checks.h"
#include "scene_argument.h"
#include "trace_arguments.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <earpoint/camera/scene_drawer.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr int kMostPixels = 8192;  // along a side

constexpr const char* kExamples = R"(
Examples:
  earpoint view flat.glb --camera 2,1.5,1.5,yaw=30,pitch=-10 -o view.png
  earpoint view --home 7 --camera 1.5,1.5,1.5,yaw=45 --size 384x216 -o view.png --mask mask.png
  earpoint view --shoebox 6,5,3 --camera 0.5,0.5,1.5,yaw=40 --fov 75 -o view.png --depth depth.png

x points to the front, y to the left, z up; yaw turns to the left, pitch looks up. --seed is the seed of
the picture's noise.
)";

struct Options {
  SceneArgument scene;
  std::string camera;
  std::string size = "256x256";
  double fov_deg = 90.0;
  fs::path output;
  std::optional<fs::path> depth;
  double depth_range_m = 10.0;
  std::optional<fs::path> mask;
  int samples = 4;
  bool keep_noise = false;
  float exposure = 1.0F;
  std::uint64_t seed = 1;
  int jobs = 0;
};

struct PictureSize {
  int width = 0;
  int height = 0;
};

PictureSize parse_size(const std::string& text) {
  PictureSize size;
  const char* end = text.data() + text.size();
  const auto [cross, first_error] = std::from_chars(text.data(), end, size.width);
  bool good = first_error == std::errc() && cross != end && *cross == 'x';
  if (good) {
    const auto [last, second_error] = std::from_chars(cross + 1, end, size.height);
    good = second_error == std::errc() && last == end;
  }
  good = good && size.width >= 1 && size.width <= kMostPixels && size.height >= 1 &&
         size.height <= kMostPixels;
  if (good) return size;
  throw InputError("--size", fmt::format("expected WIDTHxHEIGHT, each 1 to {} pixels, found '{}'",
                                         kMostPixels, text));
}

int side_of_samples(int samples) {
  const int side = static_cast<int>(std::lround(std::sqrt(std::max(0, samples))));
  if (side >= 1 && side <= 32 && side * side == samples) return side;
  throw InputError("--samples",
                   fmt::format("expected a square number from 1 to 1024, found {}", samples));
}

Camera parse_camera(const Options& options) {
  if (!(options.fov_deg >= 1.0 && options.fov_deg <= 170.0)) {
    throw InputError("--fov",
                     fmt::format("expected 1 to 170 degrees, found {:g}", options.fov_deg));
  }
  const PictureSize size = parse_size(options.size);
  return {.world_from_camera = parse_pose("--camera", options.camera),
          .horizontal_fov_rad = radians_from_degrees(options.fov_deg),
          .width = size.width,
          .height = size.height};
}

void check(const Options& options) {
  if (!(options.exposure > 0.0F) || !std::isfinite(options.exposure)) {
    throw InputError("--exposure", fmt::format("expected above 0, found {:g}", options.exposure));
  }
  if (!(options.depth_range_m > 0.0) || !std::isfinite(options.depth_range_m)) {
    throw InputError("--depth-range",
                     fmt::format("expected above 0 m, found {:g}", options.depth_range_m));
  }
  if (options.jobs < 0) {
    throw InputError("--jobs", fmt::format("expected 0 or more, found {}", options.jobs));
  }
}

void run(const Options& options) {
  check(options);
  Camera camera = parse_camera(options);
  const RenderQuality quality{.samples_per_side = side_of_samples(options.samples),
                              .denoise = !options.keep_noise,
                              .exposure = options.exposure};
  const NamedScene named = read_scene(options.scene);
  Vector3& camera_m = camera.world_from_camera.position_m;
  camera_m = camera_m - named.origin_m;
  for (const std::string& warning : named.warnings) {
    fmt::print(stderr, "earpoint: {}\n", with_flags(warning));
  }
  ThreadPool pool(options.jobs > 0 ? options.jobs : available_cores());
  const SceneDrawer drawer(named.scene, {}, pool);
  const View view = drawer.draw(camera, quality, options.seed, pool);
  write_image(options.output, view.rgb);
  if (options.depth) {
    write_image(*options.depth, picture_of_depth(view.depth_m, options.depth_range_m));
  }
  if (options.mask) write_image(*options.mask, picture_of_instances(view.instance));
}

}  // namespace

void add_view_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("view", "Render the picture that a camera takes of a scene.");
  command->footer(kExamples);
  add_scene_argument(*command, options->scene);
  command
      ->add_option("--camera", options->camera,
                   "Pose of the camera: X,Y,Z[,yaw=DEG][,pitch=DEG][,roll=DEG]")
      ->required();
  command->add_option("--size", options->size, "Size of the picture, WIDTHxHEIGHT in pixels")
      ->capture_default_str();
  command->add_option("--fov", options->fov_deg, "Horizontal field of view, degrees")
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "Picture to write (.png or .jpg)")
      ->required();
  command->add_option("--depth", options->depth,
                      "Depth along the optical axis, as a grey picture: white is near");
  command->add_option("--depth-range", options->depth_range_m, "Depth that is black, metres")
      ->capture_default_str();
  command->add_option("--mask", options->mask, "Picture of the objects, one colour each");
  command->add_option("--samples", options->samples, "Rays per pixel, a square number")
      ->capture_default_str();
  command->add_flag("--keep-noise", options->keep_noise, "Do not denoise the light");
  command->add_option("--exposure", options->exposure, "Factor on the automatic exposure")
      ->capture_default_str();
  command->add_option("--seed", options->seed, "The same seed gives the same picture")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--jobs", options->jobs, "Threads; 0 takes all cores")->capture_default_str();
  command->callback([options] { run(*options); });
}

}  // namespace earpoint
