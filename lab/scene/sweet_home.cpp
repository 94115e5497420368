#include <earpoint/scene/sweet_home.h>

#include "mannequin.h"
#include "model_reader.h"
#include "simplify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/scene/import.h>

namespace earpoint {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr std::size_t kFurnitureTriangles = 5000;
constexpr std::size_t kFigureTriangles = 6000;
constexpr int kFurnitureTexture = 256;  ///< pixels of the longer side, at most
constexpr int kFigureTexture = 512;

/// One entry of a catalogue.
struct CatalogueEntry {
  fs::path model;
  Vector3 size_m;  ///< depth, width, height
  double elevation_m = 0.0;
  std::array<double, 9> rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< rows, in the file's axes
  std::string creator;
};

struct Catalogue {
  std::map<std::string, CatalogueEntry> entries;  ///< by the model's name, without folder or ending
  std::string licence;
};

double number_of(const std::string& text, const std::string& where) {
  std::istringstream stream(text);
  double value = 0.0;
  if (!(stream >> value))
    throw InputError(where, fmt::format("expected a number, found '{}'", text));
  return value;
}

/// The lines "key#number=value" of a catalogue, by number and key; "key=value" has number "".
std::map<std::string, std::map<std::string, std::string>> properties_of(const fs::path& path) {
  std::map<std::string, std::map<std::string, std::string>> properties;
  std::istringstream lines(read_text_file(path));
  std::string line;
  while (std::getline(lines, line)) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    const std::size_t equals = line.find('=');
    if (line.starts_with('#') || equals == std::string::npos) continue;
    const std::string key = line.substr(0, equals);
    const std::size_t hash = key.find('#');
    const std::string number = hash == std::string::npos ? "" : key.substr(hash + 1);
    properties[number][key.substr(0, hash)] = line.substr(equals + 1);
  }
  return properties;
}

Catalogue read_catalogue(const fs::path& folder) {
  const fs::path path = folder / "PluginFurnitureCatalog.properties";
  Catalogue catalogue;
  for (auto& [number, values] : properties_of(path)) {
    if (number.empty()) {
      catalogue.licence = values["license"];
      // Keeps only plain ASCII, as Latin-1 characters do not matter here.
      std::erase_if(catalogue.licence, [](char c) { return static_cast<unsigned char>(c) > 126; });
      continue;
    }
    const std::string where = fmt::format("{}: #{}", path.string(), number);
    CatalogueEntry entry;
    entry.model = folder / fs::path(values["model"]).relative_path();
    entry.creator = values["creator"];
    std::erase_if(entry.creator, [](char c) { return static_cast<unsigned char>(c) > 126; });
    entry.size_m = {number_of(values["depth"], where) / 100.0,
                    number_of(values["width"], where) / 100.0,
                    number_of(values["height"], where) / 100.0};
    if (values.contains("elevation")) {
      entry.elevation_m = number_of(values["elevation"], where) / 100.0;
    }
    if (values.contains("modelRotation")) {
      std::istringstream numbers(values["modelRotation"]);
      for (double& value : entry.rotation) numbers >> value;
      if (!numbers) throw InputError(where, "modelRotation: expected 9 numbers");
    }
    catalogue.entries.emplace(entry.model.stem().string(), entry);
  }
  return catalogue;
}

/// Turns a model as its catalogue says. Ours (x, y, z) is the file's (z, x, y).
void rotate_model(Mesh& mesh, const std::array<double, 9>& r) {
  const auto turn = [&](std::array<float, 3>& v) {
    const std::array<double, 3> file = {v[1], v[2], v[0]};
    std::array<double, 3> out{};
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t i = 0; i < 3; ++i) out[row] += r[3 * row + i] * file[i];
    }
    v = {static_cast<float>(out[2]), static_cast<float>(out[0]), static_cast<float>(out[1])};
  };
  for (auto& p : mesh.positions) turn(p);
  for (auto& n : mesh.normals) turn(n);
}

/// Scales a model to its box, the middle of whose base becomes the origin.
void fit_to_box(Mesh& mesh, const Vector3& size_m) {
  const Bounds box = bounds(mesh);
  const Vector3 extent = box.high - box.low;
  const auto factor = [](double wanted, double is) { return is > 0.0 ? wanted / is : 1.0; };
  const Vector3 scale{factor(size_m.x, extent.x), factor(size_m.y, extent.y),
                      factor(size_m.z, extent.z)};
  const Vector3 origin{(box.low.x + box.high.x) / 2.0, (box.low.y + box.high.y) / 2.0, box.low.z};
  for (auto& p : mesh.positions) {
    p = {static_cast<float>((p[0] - origin.x) * scale.x),
         static_cast<float>((p[1] - origin.y) * scale.y),
         static_cast<float>((p[2] - origin.z) * scale.z)};
  }
  for (auto& n : mesh.normals) {
    const Vector3 bent{n[0] / scale.x, n[1] / scale.y, n[2] / scale.z};
    const double length = norm(bent);
    if (length == 0.0) continue;
    n = {static_cast<float>(bent.x / length), static_cast<float>(bent.y / length),
         static_cast<float>(bent.z / length)};
  }
}

/// Averages boxes of pixels until the longer side is at most `largest`.
Image shrunk(const Image& image, int largest) {
  const int longer = std::max(image.width(), image.height());
  if (longer <= largest) return image;
  const double scale = static_cast<double>(longer) / largest;
  Image small(std::max(1, static_cast<int>(image.width() / scale)),
              std::max(1, static_cast<int>(image.height() / scale)), 3);
  for (int y = 0; y < small.height(); ++y) {
    for (int x = 0; x < small.width(); ++x) {
      const int x0 = x * image.width() / small.width();
      const int x1 = std::max(x0 + 1, (x + 1) * image.width() / small.width());
      const int y0 = y * image.height() / small.height();
      const int y1 = std::max(y0 + 1, (y + 1) * image.height() / small.height());
      for (int channel = 0; channel < 3; ++channel) {
        int sum = 0;
        for (int j = y0; j < y1; ++j) {
          for (int i = x0; i < x1; ++i) sum += image.at(i, j, channel);
        }
        small.at(x, y, channel) = static_cast<std::uint8_t>(sum / ((x1 - x0) * (y1 - y0)));
      }
    }
  }
  return small;
}

void drop_unused_uvs(Scene& scene) {
  for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) {
    const Material& material = scene.materials[scene.mesh.triangle_material[i]];
    if (material.look.texture != Look::kNoTexture) continue;
    for (const std::uint32_t v : scene.mesh.triangles[i]) scene.mesh.uvs[v] = {0.0F, 0.0F};
  }
}

/// A table with the default material `sound` for names that match no pattern.
MaterialTable table_with_default(const std::string& sound) {
  return MaterialTable::parse(
      fmt::format(R"({{"format": "earpoint-materials-1", "extends": "standard", "default": "{}"}})",
                  sound),
      "sweet_home.json");
}

/// Reads one model at its size. Without texture coordinates on plain surfaces more vertices can be
/// joined.
Scene read_scene(const CatalogueEntry& entry, const MaterialTable& table, std::size_t triangles,
                 int texture_pixels) {
  ImportedScene model = read_with_assimp(entry.model, {.materials = &table}, UpAxis::y);
  Scene& scene = model.scene;
  check_scene(scene, entry.model.filename().string());
  rotate_model(scene.mesh, entry.rotation);
  fit_to_box(scene.mesh, entry.size_m);
  drop_unused_uvs(scene);
  drop_doubled_faces(scene.mesh);
  join_vertices(scene.mesh);
  simplify(scene.mesh, triangles);
  fit_to_box(scene.mesh, entry.size_m);
  check_scene(scene, entry.model.filename().string());
  if (scene.mesh.triangles.size() > 2 * triangles) {
    throw InputError(entry.model.filename().string(),
                     fmt::format("has {} triangles", scene.mesh.triangles.size()));
  }
  for (Image& texture : scene.textures) texture = shrunk(texture, texture_pixels);
  for (Material& material : scene.materials) {
    material.look.emission = {};
    // Transparent surfaces are glass, whatever their name.
    if (material.look.opacity < 0.7F) material.acoustic = standard_material("glass");
  }
  scene.instances = {{.name = entry.model.stem().string(), .kind = InstanceKind::furniture}};
  scene.mesh.triangle_instance.assign(scene.mesh.triangles.size(), 0);
  return std::move(scene);
}

/// Corrects materials from misleading names: the body of a cupboard is no person, its door no room
/// door.
void replace_unlikely_materials(Scene& scene, const AcousticMaterial& otherwise) {
  for (Material& material : scene.materials) {
    const std::string& name = material.acoustic.name;
    if (name == "person" || name == "door_wood" || name == "opening") material.acoustic = otherwise;
  }
}

/// Turns a figure so that the head looks along x, and moves its origin under the head's middle.
void face_forward(FigureModel& figure, const Vector3& lips_m, double head_yaw_rad) {
  constexpr double kLipsFromMiddle_m = 0.09;
  constexpr double kBeforeLips_m = 0.02;
  const Quaternion turn = quaternion_from_euler({.yaw_rad = -head_yaw_rad});
  const Vector3 lips = rotate(turn, lips_m);
  const Vector3 origin{lips.x - kLipsFromMiddle_m, lips.y, 0.0};
  for (auto& p : figure.scene.mesh.positions) {
    const Vector3 q = rotate(turn, {p[0], p[1], p[2]}) - origin;
    p = {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)};
  }
  for (auto& n : figure.scene.mesh.normals) {
    const Vector3 q = rotate(turn, {n[0], n[1], n[2]});
    n = {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)};
  }
  figure.mouth_m = lips - origin + Vector3{kBeforeLips_m, 0.0, 0.0};
}

/// The height of a sitting figure's seat: the lowest point of the body below the trunk.
double seat_of(const Mesh& mesh) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& p : mesh.positions) {
    if (std::abs(p[0]) < 0.1 && std::abs(p[1]) < 0.15) {
      lowest = std::min(lowest, static_cast<double>(p[2]));
    }
  }
  return std::isfinite(lowest) ? lowest : 0.0;
}

class Converter {
 public:
  explicit Converter(fs::path libraries) : libraries_(std::move(libraries)) {}

  void add_furniture(const Json& row) {
    const CatalogueEntry& entry = find(row);
    const auto kind = furniture_kind(row.at("kind").get<std::string>());
    if (!kind) throw InputError("sweet_home.json", "names an unknown kind", row.dump());
    FurnitureModel model;
    model.name = fmt::format("{}/{}", row.at("library").get<std::string>(),
                             row.at("model").get<std::string>());
    model.kind = *kind;
    model.size_m = entry.size_m;
    model.base_m = entry.elevation_m;
    model.credit = credit_of(row, entry);
    attempt(model.name, [&] {
      const auto sound = row.at("sound").get<std::string>();
      const MaterialTable table = table_with_default(sound);
      model.scene = read_scene(entry, table, kFurnitureTriangles, kFurnitureTexture);
      replace_unlikely_materials(model.scene, standard_material(sound));
      result_.pack.furniture.push_back(std::move(model));
    });
  }

  void add_figure(const Json& row);

  SweetHomeResult take() { return std::move(result_); }

 private:
  template <typename Body>
  void attempt(const std::string& name, Body&& body) {
    try {
      body();
    } catch (const InputError& error) {
      result_.left_out.push_back(fmt::format("{}: {}", name, error.what()));
    }
  }

  const Catalogue& catalogue(const std::string& library) {
    const auto known = catalogues_.find(library);
    if (known != catalogues_.end()) return known->second;
    return catalogues_.emplace(library, read_catalogue(libraries_ / library)).first->second;
  }

  const CatalogueEntry& find(const Json& row) {
    const auto library = row.at("library").get<std::string>();
    const auto model = row.at("model").get<std::string>();
    const auto& entries = catalogue(library).entries;
    const auto found = entries.find(model);
    if (found == entries.end()) {
      throw InputError(library, fmt::format("has no model '{}'", model),
                       "is sweethome3d-furniture of another version installed?");
    }
    return found->second;
  }

  std::string credit_of(const Json& row, const CatalogueEntry& entry) {
    return fmt::format("{}; {}", entry.creator,
                       catalogue(row.at("library").get<std::string>()).licence);
  }

  fs::path libraries_;
  std::map<std::string, Catalogue> catalogues_;
  SweetHomeResult result_;
};

void Converter::add_figure(const Json& row) {
  const CatalogueEntry& entry = find(row);
  FigureModel figure;
  figure.name = row.at("model").get<std::string>();
  const auto gender = gender_named(row.at("gender").get<std::string>());
  const auto posture = posture_named(row.at("posture").get<std::string>());
  if (!gender || !posture) throw InputError("sweet_home.json", "names an unknown kind", row.dump());
  figure.gender = *gender;
  figure.posture = *posture;
  figure.is_adult = row.at("adult").get<bool>();
  figure.for_test = row.at("test").get<bool>();
  figure.credit = credit_of(row, entry);
  const auto lips = row.at("lips_m").get<std::array<double, 3>>();
  const double head_yaw_rad = radians_from_degrees(row.at("head_yaw_deg").get<double>());
  attempt(figure.name, [&] {
    const MaterialTable table = table_with_default("person");
    figure.scene = read_scene(entry, table, kFigureTriangles, kFigureTexture);
    for (Material& material : figure.scene.materials) {
      material.acoustic = standard_material("person");
      material.look.roughness = 0.9F;
    }
    face_forward(figure, {lips[0], lips[1], lips[2]}, head_yaw_rad);
    if (figure.posture == Posture::sitting) figure.seat_m = seat_of(figure.scene.mesh);
    const Bounds box = bounds(figure.scene.mesh);
    figure.size_m = box.high - box.low;
    add_stool(figure);
    result_.pack.figures.push_back(std::move(figure));
  });
}

}  // namespace

SweetHomeResult convert_sweet_home(const fs::path& libraries, const fs::path& list) {
  Json json;
  try {
    json = Json::parse(read_text_file(list));
    Converter converter(libraries);
    for (const Json& row : json.at("furniture")) converter.add_furniture(row);
    for (const Json& row : json.at("figures")) converter.add_figure(row);
    return converter.take();
  } catch (const Json::exception& error) {
    throw InputError(list.string(), error.what());
  }
}

}  // namespace earpoint
