#include <earpoint/scene/people.h>

#include "mannequin.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <earpoint/error.h>
#include <earpoint/scene/material_table.h>

namespace earpoint {
namespace {

/// Appends the materials and textures of a figure to those of a scene.
/// @return offset of the figure's material indices
std::uint32_t append_surfaces(const Scene& figure, Scene& scene) {
  const auto first_material = static_cast<std::uint32_t>(scene.materials.size());
  const auto first_texture = static_cast<int>(scene.textures.size());
  for (Material material : figure.materials) {
    if (material.look.texture != Look::kNoTexture) material.look.texture += first_texture;
    scene.materials.push_back(std::move(material));
  }
  scene.textures.insert(scene.textures.end(), figure.textures.begin(), figure.textures.end());
  return first_material;
}

/// All postures, the most similar to the given one first.
std::array<Posture, 3> nearest_postures(Posture posture) {
  switch (posture) {
    case Posture::standing:
      break;
    case Posture::sitting:
      return {Posture::sitting, Posture::ground, Posture::standing};
    case Posture::ground:
      return {Posture::ground, Posture::sitting, Posture::standing};
  }
  return {Posture::standing, Posture::sitting, Posture::ground};
}

}  // namespace

std::string_view name_of(Gender gender) { return gender == Gender::female ? "female" : "male"; }

std::string_view name_of(Posture posture) {
  switch (posture) {
    case Posture::standing:
      return "standing";
    case Posture::sitting:
      return "sitting";
    case Posture::ground:
      return "ground";
  }
  return "standing";
}

std::optional<Gender> gender_named(std::string_view name) {
  for (const Gender gender : {Gender::female, Gender::male}) {
    if (name == name_of(gender)) return gender;
  }
  return std::nullopt;
}

std::optional<Posture> posture_named(std::string_view name) {
  for (const Posture posture : {Posture::standing, Posture::sitting, Posture::ground}) {
    if (name == name_of(posture)) return posture;
  }
  return std::nullopt;
}

FigureLibrary::FigureLibrary() : FigureLibrary(std::vector<FigureModel>{}) {}

FigureLibrary::FigureLibrary(std::vector<FigureModel> models) : models_(std::move(models)) {
  for (const Gender gender : {Gender::female, Gender::male}) {
    for (const Posture posture : {Posture::standing, Posture::sitting, Posture::ground}) {
      stand_ins_.push_back(make_mannequin(gender, posture));
    }
  }
}

const FigureModel& FigureLibrary::draw(Gender gender, Posture posture, FigureSplit split,
                                       RandomStream& random) const {
  for (const Posture wanted : nearest_postures(posture)) {
    std::vector<const FigureModel*> found;
    for (const FigureModel& model : models_) {
      if (model.is_adult && model.gender == gender && model.posture == wanted &&
          model.for_test == (split == FigureSplit::test)) {
        found.push_back(&model);
      }
    }
    if (!found.empty()) return *found[random.index(found.size())];
  }
  const auto stand_in = std::find_if(
      stand_ins_.begin(), stand_ins_.end(),
      [&](const FigureModel& model) { return model.gender == gender && model.posture == posture; });
  EARPOINT_CHECK(stand_in != stand_ins_.end());
  return *stand_in;
}

Person add_person(const FigureModel& figure, double x, double y, double yaw_rad, Scene& scene) {
  const Placement placement{.position_m = {x, y, 0.0}, .yaw_rad = yaw_rad};
  const Quaternion turn = quaternion_from_euler({.yaw_rad = yaw_rad});
  Person person;
  person.name = figure.name;
  person.gender = figure.gender;
  person.posture = figure.posture;
  person.world_from_head = {placed(placement, figure.mouth_m), turn};
  person.instance = static_cast<std::uint32_t>(scene.instances.size());
  scene.instances.push_back({.name = figure.name, .kind = InstanceKind::person});

  Mesh& mesh = scene.mesh;
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const std::uint32_t first_material = append_surfaces(figure.scene, scene);
  const Mesh& body = figure.scene.mesh;
  const auto to_floats = [](const Vector3& v) {
    return std::array<float, 3>{static_cast<float>(v.x), static_cast<float>(v.y),
                                static_cast<float>(v.z)};
  };
  for (std::size_t i = 0; i < body.positions.size(); ++i) {
    const auto& n = body.normals[i];
    mesh.positions.push_back(
        to_floats(placed(placement, vertex(body, static_cast<std::uint32_t>(i)))));
    if (!mesh.normals.empty()) mesh.normals.push_back(to_floats(rotate(turn, {n[0], n[1], n[2]})));
    if (!mesh.uvs.empty()) mesh.uvs.push_back(body.uvs[i]);
  }
  for (std::size_t i = 0; i < body.triangles.size(); ++i) {
    const auto& [a, b, c] = body.triangles[i];
    mesh.triangles.push_back({first + a, first + b, first + c});
    mesh.triangle_material.push_back(first_material + body.triangle_material[i]);
    mesh.triangle_instance.push_back(person.instance);
  }
  return person;
}

}  // namespace earpoint
