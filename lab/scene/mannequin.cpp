#include "mannequin.h"

#include <cmath>
#include <limits>

#include <earpoint/scene/material_table.h>
#include <earpoint/scene/texture.h>

namespace earpoint {
namespace {

Material cloth(const ScreenColour& colour) {
  Material material{.acoustic = standard_material("person"), .look = {}};
  material.look.base_colour = linear_colour(colour);
  material.look.roughness = 0.9F;
  return material;
}

/// Builds a mannequin upwards from where its hips are.
class MannequinMaker {
 public:
  MannequinMaker(Gender gender, Posture posture)
      : is_female_(gender == Gender::female),
        posture_(posture),
        scale_(is_female_ ? 1.64 / 1.77 : 1.0) {
    builder_.begin_instance("mannequin", InstanceKind::person);
    skin_ = builder_.add_surface("skin", cloth({0.80F, 0.62F, 0.52F}));
    hair_ = builder_.add_surface("hair", cloth(is_female_ ? ScreenColour{0.45F, 0.25F, 0.15F}
                                                          : ScreenColour{0.22F, 0.18F, 0.15F}));
    top_ = builder_.add_surface("top", cloth(is_female_ ? ScreenColour{0.70F, 0.30F, 0.35F}
                                                        : ScreenColour{0.28F, 0.38F, 0.55F}));
    legs_ = builder_.add_surface("legs", cloth({0.25F, 0.26F, 0.32F}));
  }

  FigureModel make() {
    const double hips_m = posture_ == Posture::standing  ? 0.86 * scale_
                          : posture_ == Posture::sitting ? kSeat_m + 0.04 * scale_
                                                         : 0.05 * scale_;
    add_legs(hips_m);
    add_torso(hips_m);
    FigureModel figure;
    figure.mouth_m = {0.13 * scale_, 0.0, hips_m + 0.74 * scale_};
    figure.posture = posture_;
    figure.seat_m = posture_ == Posture::sitting ? kSeat_m : 0.0;
    figure.scene = builder_.take();
    const Bounds box = bounds(figure.scene.mesh);
    figure.size_m = box.high - box.low;
    return figure;
  }

 private:
  void ellipsoid(const Vector3& centre, const Vector3& radii, Surface surface) {
    builder_.add_ellipsoid(centre, radii, 16, surface);
  }

  void add_torso(double hips_m) {
    const double s = scale_;
    const double shoulder = is_female_ ? 0.18 : 0.22;
    ellipsoid({0, 0, hips_m + 0.10 * s}, {0.13 * s, 0.19 * s, 0.14 * s}, legs_);
    ellipsoid({0, 0, hips_m + 0.34 * s}, {0.12 * s, shoulder * s, 0.27 * s}, top_);
    builder_.add_cylinder({0.01, 0, hips_m + 0.52 * s}, 0.06 * s, 0.055 * s, 0.14 * s, 14, skin_);
    const Vector3 head{0.02 * s, 0, hips_m + 0.785 * s};
    ellipsoid(head, {0.095 * s, 0.075 * s, 0.12 * s}, skin_);
    ellipsoid(head + Vector3{-0.022 * s, 0, 0.03 * s}, {0.09 * s, 0.08 * s, 0.105 * s}, hair_);
    ellipsoid(head + Vector3{0.09 * s, 0, -0.005 * s}, {0.02 * s, 0.014 * s, 0.022 * s}, skin_);
    for (const double side : {-1.0, 1.0}) {
      const double y = side * (shoulder + 0.03) * s;
      ellipsoid({0.0, y, hips_m + 0.36 * s}, {0.05 * s, 0.05 * s, 0.17 * s}, top_);
      ellipsoid({0.05 * s, y, hips_m + 0.10 * s}, {0.06 * s, 0.04 * s, 0.15 * s}, top_);
      ellipsoid({0.09 * s, y, hips_m + 0.02 * s}, {0.04 * s, 0.03 * s, 0.02 * s}, skin_);
    }
  }

  void add_legs(double hips_m) {
    const double s = scale_;
    for (const double side : {-1.0, 1.0}) {
      const double y = side * 0.095 * s;
      switch (posture_) {
        case Posture::standing:
          builder_.add_cylinder({0, y, 0.05}, 0.05 * s, 0.085 * s, hips_m, 14, legs_);
          ellipsoid({0.06 * s, y, 0.045}, {0.13 * s, 0.045 * s, 0.045}, hair_);
          break;
        case Posture::sitting:
          ellipsoid({0.22 * s, y, hips_m + 0.075 * s}, {0.28 * s, 0.08 * s, 0.075 * s}, legs_);
          builder_.add_cylinder({0.42 * s, y, 0.05}, 0.045 * s, 0.06 * s, hips_m, 14, legs_);
          ellipsoid({0.48 * s, y, 0.045}, {0.13 * s, 0.045 * s, 0.045}, hair_);
          break;
        case Posture::ground:
          ellipsoid({0.22 * s, 2.2 * y, 0.09 * s}, {0.24 * s, 0.09 * s, 0.085 * s}, legs_);
          ellipsoid({0.36 * s, -0.6 * y, 0.06 * s}, {0.08 * s, 0.2 * s, 0.055 * s}, legs_);
          break;
      }
    }
  }

  bool is_female_;
  Posture posture_;
  double scale_;
  SceneBuilder builder_;
  Surface skin_;
  Surface hair_;
  Surface top_;
  Surface legs_;
};

}  // namespace

FigureModel make_mannequin(Gender gender, Posture posture) {
  FigureModel figure = MannequinMaker(gender, posture).make();
  figure.name = std::string(name_of(gender)) + " mannequin";
  figure.gender = gender;
  figure.credit = "Earpoint";
  add_stool(figure);
  return figure;
}

void add_stool(FigureModel& figure) {
  if (figure.posture != Posture::sitting) return;
  // The seat begins below the back of the hips and ends before the shins.
  const Mesh& body = figure.scene.mesh;
  double back = std::numeric_limits<double>::infinity();
  for (const auto& p : body.positions) {
    if (p[2] < figure.seat_m + 0.02 || p[2] > figure.seat_m + 0.16) continue;
    if (std::abs(p[1]) < 0.12) back = std::min(back, static_cast<double>(p[0]));
  }
  if (!std::isfinite(back)) back = -0.2;
  SceneBuilder builder;
  builder.begin_instance("stool", InstanceKind::person);
  Material cover{.acoustic = standard_material("upholstery_fabric"), .look = {}};
  cover.look.base_colour = linear_colour({0.42F, 0.38F, 0.36F});
  const Surface surface = builder.add_surface("cover", cover);
  builder.add_box({back, -0.22, 0.0}, {back + 0.38, 0.22, figure.seat_m - 0.004}, surface);
  const Scene stool = builder.take();
  Mesh& mesh = figure.scene.mesh;
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto material = static_cast<std::uint32_t>(figure.scene.materials.size());
  figure.scene.materials.push_back(stool.materials[0]);
  mesh.positions.insert(mesh.positions.end(), stool.mesh.positions.begin(),
                        stool.mesh.positions.end());
  mesh.normals.insert(mesh.normals.end(), stool.mesh.normals.begin(), stool.mesh.normals.end());
  mesh.uvs.insert(mesh.uvs.end(), stool.mesh.uvs.begin(), stool.mesh.uvs.end());
  for (const auto& [a, b, c] : stool.mesh.triangles) {
    mesh.triangles.push_back({first + a, first + b, first + c});
    mesh.triangle_material.push_back(material);
    mesh.triangle_instance.push_back(0);
  }
  const Bounds box = bounds(mesh);
  figure.size_m = box.high - box.low;
}

}  // namespace earpoint
