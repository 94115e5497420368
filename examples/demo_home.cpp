#include "demo_home.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <earpoint/error.h>
#include <earpoint/scene/homes.h>
#include <earpoint/scene/model_pack.h>

namespace earpoint {
namespace {

// `earpoint view --home 31` shows the same home.
constexpr std::uint64_t kHomeSeed = 31;
constexpr double kEyeHeight_m = 1.5;
constexpr int kWidth = 960;
constexpr int kHeight = 540;
// A person of the test split: in no data set that a shipped model was trained on.
constexpr const char* kFigure = "male03";

/// A position in the home and a heading.
struct Stand {
  double x = 0.0;
  double y = 0.0;
  double yaw_deg = 0.0;
};

constexpr Stand kCamera{4.3, 2.2, 90.0};
constexpr Stand kSpeaker{4.1, 4.2, -88.0};

struct NamedStand {
  const char* name;
  Stand stand;
};

constexpr std::array<NamedStand, 4> kEarpoints{{
    {"speaker on the left", {4.5, 3.69, 45.0}},
    {"speaker on the right", {3.7, 3.69, 135.0}},
    {"far away", {1.0, 0.6, 49.0}},
    {"in the next room", {3.6, 7.1, -125.0}},
}};

Pose world_from(const Stand& stand) {
  return {{stand.x, stand.y, kEyeHeight_m},
          quaternion_from_euler({.yaw_rad = radians_from_degrees(stand.yaw_deg)})};
}

const FigureModel& figure_named(const std::vector<FigureModel>& figures, const char* name) {
  const auto found = std::ranges::find(figures, name, &FigureModel::name);
  if (found == figures.end()) {
    throw InputError("installed models", std::string("hold no person named ") + name,
                     "run ./dev assets");
  }
  return *found;
}

double to_centimetre(double metres) { return std::round(metres * 100.0) / 100.0; }

/// The scene without everything above a height: ceilings, hanging lamps, lintels.
Scene cut_open(Scene scene, double height_m) {
  Mesh& mesh = scene.mesh;
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const bool is_above = std::ranges::all_of(
        mesh.triangles[t], [&](std::uint32_t corner) { return vertex(mesh, corner).z > height_m; });
    if (is_above) continue;
    mesh.triangles[kept] = mesh.triangles[t];
    mesh.triangle_material[kept] = mesh.triangle_material[t];
    mesh.triangle_instance[kept] = mesh.triangle_instance[t];
    ++kept;
  }
  mesh.triangles.resize(kept);
  mesh.triangle_material.resize(kept);
  mesh.triangle_instance.resize(kept);
  scene.lamps.clear();
  return scene;
}

}  // namespace

DemoHome make_demo_home() {
  ModelPack pack = installed_models();
  DemoHome home;
  home.scene = make_home(kHomeSeed, {}, FurnitureLibrary(std::move(pack.furniture))).scene;
  home.speaker = add_person(figure_named(pack.figures, kFigure), kSpeaker.x, kSpeaker.y,
                            radians_from_degrees(kSpeaker.yaw_deg), home.scene);
  home.camera = {.world_from_camera = world_from(kCamera), .width = kWidth, .height = kHeight};
  return home;
}

std::vector<DemoEarpoint> demo_earpoints(const DemoHome& home) {
  std::vector<DemoEarpoint> earpoints;
  for (const NamedStand& named : kEarpoints) {
    const Pose exact = inverse(home.camera.world_from_camera) * world_from(named.stand);
    DemoEarpoint& earpoint = earpoints.emplace_back();
    earpoint.name = named.name;
    earpoint.yaw_deg =
        std::round(degrees_from_radians(euler_from_quaternion(exact.orientation).yaw_rad));
    earpoint.source_from_target = {
        {to_centimetre(exact.position_m.x), to_centimetre(exact.position_m.y), 0.0},
        quaternion_from_euler({.yaw_rad = radians_from_degrees(earpoint.yaw_deg)})};
  }
  return earpoints;
}

FloorMapPicture picture_from_above(const DemoHome& home, ThreadPool& pool) {
  constexpr double kCut_m = 2.2;
  constexpr double kMargin_m = 0.3;
  // From so high up, perspective shifts things of a person's height by a few centimetres only.
  constexpr double kHeightAbove_m = 150.0;
  constexpr double kPixelsPerMetre = 80.0;
  const Scene open = cut_open(home.scene, kCut_m);
  // The home's extent along the camera's axes.
  const Pose camera_from_world = inverse(home.camera.world_from_camera);
  Vector3 low{1e9, 1e9, 0.0};
  Vector3 high{-1e9, -1e9, 0.0};
  for (const auto& corners : open.mesh.triangles) {
    for (const std::uint32_t corner : corners) {
      const Vector3 p = transform_point(camera_from_world, vertex(open.mesh, corner));
      low = {std::min(low.x, p.x), std::min(low.y, p.y), 0.0};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), 0.0};
    }
  }
  const double width_m = high.y - low.y + 2.0 * kMargin_m;
  const double height_m = high.x - low.x + 2.0 * kMargin_m;
  const Vector3 middle{(low.x + high.x) / 2.0, (low.y + high.y) / 2.0, kHeightAbove_m};
  const Pose camera_from_view{middle, quaternion_from_euler({.pitch_rad = -kPi / 2.0})};
  const Camera above{
      .world_from_camera = home.camera.world_from_camera * camera_from_view,
      .horizontal_fov_rad = 2.0 * std::atan(width_m / 2.0 / (kHeightAbove_m + kEyeHeight_m)),
      .width = static_cast<int>(std::lround(width_m * kPixelsPerMetre)),
      .height = static_cast<int>(std::lround(height_m * kPixelsPerMetre))};
  FloorMapPicture map;
  map.rgb = SceneDrawer(open, {}, pool).draw(above, {.samples_per_side = 4}, 1, pool).rgb;
  map.pixels_per_metre = kPixelsPerMetre;
  map.camera = {(high.y + kMargin_m) * kPixelsPerMetre, (high.x + kMargin_m) * kPixelsPerMetre};
  return map;
}

}  // namespace earpoint
