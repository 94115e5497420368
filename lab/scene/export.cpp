#include <earpoint/scene/export.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <span>
#include <unordered_map>
#include <vector>

#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/media/image_file.h>

namespace earpoint {
namespace {

using Json = nlohmann::json;

// Numbers that glTF 2.0 defines.
constexpr std::uint32_t kMagic = 0x46546C67;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;
constexpr int kFloat = 5126;
constexpr int kUnsignedInt = 5125;

std::array<float, 3> y_up(const std::array<float, 3>& v) { return {v[1], v[2], v[0]}; }

class GlbWriter {
 public:
  explicit GlbWriter(const Scene& scene) : scene_(scene) {
    json_["asset"] = {{"version", "2.0"}, {"generator", "earpoint"}};
    json_["scene"] = 0;
  }

  std::vector<std::byte> write() {
    add_textures();
    add_materials();
    add_meshes();
    while (binary_.size() % 4 != 0) binary_.push_back(std::byte{0});
    json_["buffers"] = {{{"byteLength", binary_.size()}}};
    std::string text = json_.dump();
    while (text.size() % 4 != 0) text.push_back(' ');
    std::vector<std::byte> file;
    const auto put = [&](std::uint32_t value) {
      append(file, std::as_bytes(std::span(&value, 1)));
    };
    put(kMagic);
    put(2);
    put(static_cast<std::uint32_t>(12 + 8 + text.size() + 8 + binary_.size()));
    put(static_cast<std::uint32_t>(text.size()));
    put(kJsonChunk);
    append(file, std::as_bytes(std::span(text)));
    put(static_cast<std::uint32_t>(binary_.size()));
    put(kBinaryChunk);
    append(file, binary_);
    return file;
  }

 private:
  static void append(std::vector<std::byte>& to, std::span<const std::byte> bytes) {
    to.insert(to.end(), bytes.begin(), bytes.end());
  }

  /// @return the index of a new buffer view
  std::size_t add_view(std::span<const std::byte> bytes) {
    while (binary_.size() % 4 != 0) binary_.push_back(std::byte{0});
    json_["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes.size()}});
    append(binary_, bytes);
    return json_["bufferViews"].size() - 1;
  }

  template <typename T>
  std::size_t add_accessor(const std::vector<T>& values, const char* type, int component) {
    const std::size_t view = add_view(std::as_bytes(std::span(values)));
    json_["accessors"].push_back({{"bufferView", view},
                                  {"componentType", component},
                                  {"count", values.size()},
                                  {"type", type}});
    return json_["accessors"].size() - 1;
  }

  void add_textures() {
    for (const Image& texture : scene_.textures) {
      json_["images"].push_back(
          {{"bufferView", add_view(encode_png(texture))}, {"mimeType", "image/png"}});
      json_["textures"].push_back({{"source", json_["images"].size() - 1}});
    }
  }

  void add_materials() {
    for (const Material& material : scene_.materials) {
      const Look& look = material.look;
      Json surface = {
          {"baseColorFactor",
           {look.base_colour[0], look.base_colour[1], look.base_colour[2], look.opacity}},
          {"roughnessFactor", look.roughness},
          {"metallicFactor", look.metallic}};
      if (look.texture != Look::kNoTexture) surface["baseColorTexture"] = {{"index", look.texture}};
      std::array<float, 3> emission = look.emission;
      for (float& part : emission) part = std::min(part, 1.0F);  // glTF's limit
      json_["materials"].push_back({{"name", material.acoustic.name},
                                    {"doubleSided", true},
                                    {"emissiveFactor", emission},
                                    {"alphaMode", look.opacity < 1.0F ? "BLEND" : "OPAQUE"},
                                    {"pbrMetallicRoughness", surface}});
    }
  }

  /// The faces of one instance that share a material, with vertices of their own.
  Json primitive(const std::vector<std::size_t>& faces, std::uint32_t material) {
    std::unordered_map<std::uint32_t, std::uint32_t> moved;
    std::vector<std::uint32_t> indices;
    std::vector<std::array<float, 3>> positions;
    std::vector<std::array<float, 3>> normals;
    std::vector<std::array<float, 2>> uvs;
    const Mesh& mesh = scene_.mesh;
    for (const std::size_t face : faces) {
      for (const std::uint32_t v : mesh.triangles[face]) {
        const auto [entry, is_new] =
            moved.try_emplace(v, static_cast<std::uint32_t>(positions.size()));
        indices.push_back(entry->second);
        if (!is_new) continue;
        positions.push_back(y_up(mesh.positions[v]));
        if (!mesh.normals.empty()) normals.push_back(y_up(mesh.normals[v]));
        // glTF counts v from the top of the picture.
        if (!mesh.uvs.empty()) uvs.push_back({mesh.uvs[v][0], 1.0F - mesh.uvs[v][1]});
      }
    }
    Json attributes;
    attributes["POSITION"] = add_accessor(positions, "VEC3", kFloat);
    add_limits(positions);
    if (!normals.empty()) attributes["NORMAL"] = add_accessor(normals, "VEC3", kFloat);
    if (!uvs.empty()) attributes["TEXCOORD_0"] = add_accessor(uvs, "VEC2", kFloat);
    const std::size_t index_accessor = add_accessor(indices, "SCALAR", kUnsignedInt);
    return {{"attributes", attributes}, {"indices", index_accessor}, {"material", material}};
  }

  void add_limits(const std::vector<std::array<float, 3>>& positions) {
    std::array<float, 3> low = positions[0];
    std::array<float, 3> high = positions[0];
    for (const auto& p : positions) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    }
    json_["accessors"].back()["min"] = low;
    json_["accessors"].back()["max"] = high;
  }

  void add_meshes() {
    std::map<std::uint32_t, std::map<std::uint32_t, std::vector<std::size_t>>> faces;
    for (std::size_t i = 0; i < scene_.mesh.triangles.size(); ++i) {
      faces[scene_.mesh.triangle_instance[i]][scene_.mesh.triangle_material[i]].push_back(i);
    }
    Json roots = Json::array();
    for (const auto& [instance, by_material] : faces) {
      Json primitives = Json::array();
      for (const auto& [material, list] : by_material) {
        primitives.push_back(primitive(list, material));
      }
      const std::string& name = scene_.instances[instance].name;
      json_["meshes"].push_back({{"name", name}, {"primitives", primitives}});
      json_["nodes"].push_back({{"name", name}, {"mesh", json_["meshes"].size() - 1}});
      roots.push_back(json_["nodes"].size() - 1);
    }
    json_["scenes"] = {{{"nodes", roots}}};
  }

  const Scene& scene_;
  Json json_;
  std::vector<std::byte> binary_;
};

}  // namespace

void write_glb(const Scene& scene, const std::filesystem::path& path) {
  write_file(path, GlbWriter(scene).write());
}

}  // namespace earpoint
