#include <earpoint/scene/model_pack.h>

#include <bit>
#include <cstdlib>
#include <cstring>
#include <span>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/data_folder.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/scene/material_table.h>

namespace earpoint {
namespace {

using Json = nlohmann::json;

static_assert(std::endian::native == std::endian::little, "packs are little-endian");

constexpr std::string_view kFormat = "earpoint-models-1";
constexpr std::size_t kLongestHeader_bytes = 64 << 20;

/// Collects the numbers that follow the header.
class BlobWriter {
 public:
  template <typename T>
  Json add(std::span<const T> values) {
    const auto bytes = std::as_bytes(values);
    Json place = {bytes_.size(), values.size()};
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    while (bytes_.size() % 8 != 0) bytes_.push_back(std::byte{0});
    return place;
  }
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

Json json_of(const Vector3& v) { return {v.x, v.y, v.z}; }

Json json_of(const Scene& scene, BlobWriter& blob) {
  Json json;
  const Mesh& mesh = scene.mesh;
  json["positions"] = blob.add(std::span(mesh.positions));
  json["normals"] = blob.add(std::span(mesh.normals));
  json["uvs"] = blob.add(std::span(mesh.uvs));
  json["triangles"] = blob.add(std::span(mesh.triangles));
  json["triangle_material"] = blob.add(std::span(mesh.triangle_material));
  json["materials"] = Json::array();
  for (const Material& material : scene.materials) {
    const Look& look = material.look;
    json["materials"].push_back({{"sound", material.acoustic.name},
                                 {"base_colour", look.base_colour},
                                 {"texture", look.texture},
                                 {"roughness", look.roughness},
                                 {"metallic", look.metallic},
                                 {"opacity", look.opacity},
                                 {"emission", look.emission}});
  }
  json["textures"] = Json::array();
  for (const Image& texture : scene.textures) {
    json["textures"].push_back({{"width", texture.width()},
                                {"height", texture.height()},
                                {"pixels", blob.add(texture.pixels())}});
  }
  return json;
}

/// Reads the header's fields and the numbers that they point to; every error is an InputError.
class PackReader {
 public:
  PackReader(const std::filesystem::path& path) : where_(path.string()), bytes_(read_file(path)) {}

  ModelPack read() {
    try {
      return read_pack();
    } catch (const Json::exception& error) {
      fail(error.what());
    }
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw InputError(where_, fmt::format("is damaged: {}", problem), "make it again: ./dev assets");
  }

  ModelPack read_pack() {
    const auto newline = std::find(bytes_.begin(), bytes_.end(), std::byte{'\n'});
    const auto length = static_cast<std::size_t>(newline - bytes_.begin());
    if (newline == bytes_.end() || length > kLongestHeader_bytes) fail("no header");
    const Json header =
        Json::parse(std::string_view(reinterpret_cast<const char*>(bytes_.data()), length));
    if (header.at("format") != kFormat) fail("it is of another version");
    blob_ = std::span(bytes_).subspan(length + 1);
    if (header.at("bytes").get<std::size_t>() != blob_.size()) fail("it is truncated");
    ModelPack pack;
    for (const Json& json : header.at("furniture")) pack.furniture.push_back(read_furniture(json));
    for (const Json& json : header.at("figures")) pack.figures.push_back(read_figure(json));
    return pack;
  }

  static Vector3 vector_of(const Json& json) {
    return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
  }

  FurnitureModel read_furniture(const Json& json) const {
    FurnitureModel model;
    model.name = json.at("name").get<std::string>();
    const auto kind = furniture_kind(json.at("kind").get<std::string>());
    if (!kind) fail(fmt::format("{} is of an unknown kind", model.name));
    model.kind = *kind;
    model.size_m = vector_of(json.at("size_m"));
    model.base_m = json.at("base_m").get<double>();
    model.credit = json.at("credit").get<std::string>();
    model.scene = read_scene(json.at("scene"), model.name);
    return model;
  }

  FigureModel read_figure(const Json& json) const {
    FigureModel model;
    model.name = json.at("name").get<std::string>();
    const auto gender = gender_named(json.at("gender").get<std::string>());
    const auto posture = posture_named(json.at("posture").get<std::string>());
    if (!gender || !posture) fail(fmt::format("{} is of an unknown kind", model.name));
    model.gender = *gender;
    model.posture = *posture;
    model.is_adult = json.at("is_adult").get<bool>();
    model.for_test = json.at("for_test").get<bool>();
    model.size_m = vector_of(json.at("size_m"));
    model.mouth_m = vector_of(json.at("mouth_m"));
    model.seat_m = json.at("seat_m").get<double>();
    model.credit = json.at("credit").get<std::string>();
    model.scene = read_scene(json.at("scene"), model.name);
    return model;
  }

  template <typename T>
  std::vector<T> read_array(const Json& place) const {
    const auto offset = place.at(0).get<std::size_t>();
    const auto count = place.at(1).get<std::size_t>();
    if (offset > blob_.size() || count > (blob_.size() - offset) / sizeof(T)) {
      fail("an array ends after the end of the file");
    }
    std::vector<T> values(count);
    if (count > 0) std::memcpy(values.data(), blob_.data() + offset, count * sizeof(T));
    return values;
  }

  Scene read_scene(const Json& json, const std::string& name) const {
    Scene scene;
    scene.mesh.positions = read_array<std::array<float, 3>>(json.at("positions"));
    scene.mesh.normals = read_array<std::array<float, 3>>(json.at("normals"));
    scene.mesh.uvs = read_array<std::array<float, 2>>(json.at("uvs"));
    scene.mesh.triangles = read_array<std::array<std::uint32_t, 3>>(json.at("triangles"));
    scene.mesh.triangle_material = read_array<std::uint32_t>(json.at("triangle_material"));
    scene.mesh.triangle_instance.assign(scene.mesh.triangles.size(), 0);
    scene.instances.push_back({.name = name, .kind = InstanceKind::furniture});
    for (const Json& entry : json.at("materials")) scene.materials.push_back(read_material(entry));
    for (const Json& entry : json.at("textures")) scene.textures.push_back(read_texture(entry));
    const std::size_t faces = scene.mesh.triangles.size();
    if (check_scene(scene, fmt::format("{}: {}", where_, name)).zero_area_triangles > 0 ||
        scene.mesh.triangles.size() != faces) {
      fail(fmt::format("{} has faces without an area", name));
    }
    return scene;
  }

  Material read_material(const Json& json) const {
    Material material;
    const auto sound = json.at("sound").get<std::string>();
    const AcousticMaterial* acoustic = standard_materials().find(sound);
    if (acoustic == nullptr) fail(fmt::format("'{}' is not a standard material", sound));
    material.acoustic = *acoustic;
    material.look.base_colour = json.at("base_colour").get<std::array<float, 3>>();
    material.look.texture = json.at("texture").get<int>();
    material.look.roughness = json.at("roughness").get<float>();
    material.look.metallic = json.at("metallic").get<float>();
    material.look.opacity = json.at("opacity").get<float>();
    material.look.emission = json.at("emission").get<std::array<float, 3>>();
    return material;
  }

  Image read_texture(const Json& json) const {
    const int width = json.at("width").get<int>();
    const int height = json.at("height").get<int>();
    const auto pixels = read_array<std::uint8_t>(json.at("pixels"));
    constexpr int kLargest = 1 << 14;
    if (width <= 0 || height <= 0 || width > kLargest || height > kLargest ||
        pixels.size() != static_cast<std::size_t>(width) * height * 3) {
      fail("a texture's size does not fit its pixels");
    }
    Image image(width, height, 3);
    std::copy(pixels.begin(), pixels.end(), image.pixels().begin());
    return image;
  }

  std::string where_;
  std::vector<std::byte> bytes_;
  std::span<const std::byte> blob_;
};

}  // namespace

void write_model_pack(const ModelPack& pack, const std::filesystem::path& path) {
  BlobWriter blob;
  Json header = {{"format", kFormat}, {"furniture", Json::array()}, {"figures", Json::array()}};
  for (const FurnitureModel& model : pack.furniture) {
    header["furniture"].push_back({{"name", model.name},
                                   {"kind", name_of(model.kind)},
                                   {"size_m", json_of(model.size_m)},
                                   {"base_m", model.base_m},
                                   {"credit", model.credit},
                                   {"scene", json_of(model.scene, blob)}});
  }
  for (const FigureModel& model : pack.figures) {
    header["figures"].push_back({{"name", model.name},
                                 {"gender", name_of(model.gender)},
                                 {"posture", name_of(model.posture)},
                                 {"is_adult", model.is_adult},
                                 {"for_test", model.for_test},
                                 {"size_m", json_of(model.size_m)},
                                 {"mouth_m", json_of(model.mouth_m)},
                                 {"seat_m", model.seat_m},
                                 {"credit", model.credit},
                                 {"scene", json_of(model.scene, blob)}});
  }
  header["bytes"] = blob.bytes().size();
  const std::string line = header.dump() + "\n";
  std::vector<std::byte> file;
  file.reserve(line.size() + blob.bytes().size());
  const auto text = std::as_bytes(std::span(line));
  file.insert(file.end(), text.begin(), text.end());
  file.insert(file.end(), blob.bytes().begin(), blob.bytes().end());
  write_file(path, file);
}

ModelPack read_model_pack(const std::filesystem::path& path) { return PackReader(path).read(); }

std::optional<std::filesystem::path> installed_model_pack() {
  const auto folder = data_folder();
  if (!folder) return std::nullopt;
  std::filesystem::path path = *folder / "models.pack";
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::nullopt;
  return path;
}

ModelPack installed_models() {
  const auto path = installed_model_pack();
  return path ? read_model_pack(*path) : ModelPack{};
}

std::string warning_of(const ModelPack& models) {
  if (!models.furniture.empty()) return {};
  return "no models of furniture and people are installed, and plain shapes stand in for them; "
         "install the models with ./dev assets";
}

}  // namespace earpoint
