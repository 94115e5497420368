#include "colour_palette.h"
#include "gltf_floats.h"
#include "model_reader.h"
#include "polygon.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <set>

#include <assimp/GltfMaterial.h>
#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>
#include <earpoint/scene/texture.h>

namespace earpoint {
namespace {

constexpr std::string_view kHint = "export it again, or convert it with another program";
constexpr unsigned int kSteps = aiProcess_SortByPType | aiProcess_GenUVCoords;

/// Textures of a model, each decoded once.
class TextureStore {
 public:
  TextureStore(const aiScene& source, std::filesystem::path folder, ImportedScene& target)
      : source_(source), folder_(std::move(folder)), target_(target) {}

  /// @return an index into Scene::textures; Look::kNoTexture if it cannot be read, which is
  /// reported
  int find(const std::string& name) {
    if (const auto known = known_.find(name); known != known_.end()) return known->second;
    int index = Look::kNoTexture;
    if (std::optional<Image> image = load(name)) {
      index = static_cast<int>(target_.scene.textures.size());
      target_.scene.textures.push_back(std::move(*image));
    } else {
      target_.report.missing_textures.push_back(one_line(name));
    }
    known_.emplace(name, index);
    return index;
  }

 private:
  std::optional<Image> load(const std::string& name) {
    try {
      if (const aiTexture* embedded = source_.GetEmbeddedTexture(name.c_str())) {
        return load_embedded(*embedded, name);
      }
      std::string relative = name;
      std::replace(relative.begin(), relative.end(), '\\', '/');
      return read_image(folder_ / relative);
    } catch (const InputError&) {
      return std::nullopt;  // reported by find()
    }
  }

  static Image load_embedded(const aiTexture& texture, const std::string& name) {
    if (texture.mHeight == 0) {
      const auto* bytes = reinterpret_cast<const std::byte*>(texture.pcData);
      return decode_image({bytes, texture.mWidth}, name);
    }
    Image image(static_cast<int>(texture.mWidth), static_cast<int>(texture.mHeight), 3);
    for (std::size_t i = 0; i < image.pixels().size() / 3; ++i) {
      const aiTexel& texel = texture.pcData[i];
      image.pixels()[3 * i] = texel.r;
      image.pixels()[3 * i + 1] = texel.g;
      image.pixels()[3 * i + 2] = texel.b;
    }
    return image;
  }

  const aiScene& source_;
  std::filesystem::path folder_;
  ImportedScene& target_;
  std::map<std::string, int> known_;
};

float clamped_share(float value) {
  return std::isfinite(value) ? std::clamp(value, 0.0F, 1.0F) : 0.0F;
}

std::array<float, 3> colour_of(const aiColor3D& c) {
  return {clamped_share(c.r), clamped_share(c.g), clamped_share(c.b)};
}

Look look_of(const aiMaterial& material, TextureStore& textures) {
  Look look;
  aiColor4D base;
  aiColor3D colour;
  if (material.Get(AI_MATKEY_BASE_COLOR, base) == aiReturn_SUCCESS) {
    look.base_colour = colour_of({base.r, base.g, base.b});  // glTF: linear
  } else if (material.Get(AI_MATKEY_COLOR_DIFFUSE, colour) == aiReturn_SUCCESS) {
    look.base_colour = linear_colour(colour_of(colour));  // others: as on a screen
  }
  if (material.Get(AI_MATKEY_COLOR_EMISSIVE, colour) == aiReturn_SUCCESS) {
    look.emission = colour_of(colour);
  }
  float value = 0.0F;
  if (material.Get(AI_MATKEY_ROUGHNESS_FACTOR, value) == aiReturn_SUCCESS) {
    look.roughness = clamped_share(value);
  } else if (material.Get(AI_MATKEY_SHININESS, value) == aiReturn_SUCCESS && value > 0.0F) {
    look.roughness = clamped_share(std::sqrt(2.0F / (value + 2.0F)));  // Blinn-Phong's exponent
  }
  if (material.Get(AI_MATKEY_METALLIC_FACTOR, value) == aiReturn_SUCCESS) {
    look.metallic = clamped_share(value);
  }
  // Some exporters write "transparency 1" for opaque: an opacity of 0 is ignored.
  if (material.Get(AI_MATKEY_OPACITY, value) == aiReturn_SUCCESS && value > 0.0F) {
    look.opacity = clamped_share(value);
  }
  for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
    aiString name;
    if (material.GetTexture(type, 0, &name) != aiReturn_SUCCESS || name.length == 0) continue;
    look.texture = textures.find(name.C_Str());
    // Outside glTF the diffuse colour beside a texture is whatever an exporter left there.
    const bool is_gltf = material.Get(AI_MATKEY_BASE_COLOR, base) == aiReturn_SUCCESS;
    if (look.texture != Look::kNoTexture && !is_gltf) look.base_colour = {1.0F, 1.0F, 1.0F};
    break;
  }
  return look;
}

/// Copies a model node by node.
class AssimpReader {
 public:
  AssimpReader(const aiScene& source, const std::filesystem::path& path,
               const ImportOptions& options, UpAxis up_axis)
      : source_(source),
        table_(options.materials != nullptr ? *options.materials : standard_materials()),
        textures_(source, path.parent_path(), result_),
        up_axis_(up_axis),
        unit_m_(options.unit_m) {}

  ImportedScene read() {
    if (source_.mRootNode != nullptr) read_node(*source_.mRootNode, aiMatrix4x4());
    store_palette();
    mend_normals(result_.scene.mesh);
    return std::move(result_);
  }

 private:
  void read_node(const aiNode& node, const aiMatrix4x4& parent) {
    const aiMatrix4x4 world = parent * node.mTransformation;
    for (unsigned int i = 0; i < node.mNumMeshes; ++i) {
      read_mesh(*source_.mMeshes[node.mMeshes[i]], node, world);
    }
    for (unsigned int i = 0; i < node.mNumChildren; ++i) read_node(*node.mChildren[i], world);
  }

  void read_mesh(const aiMesh& mesh, const aiNode& node, const aiMatrix4x4& world) {
    constexpr unsigned int kFaces = aiPrimitiveType_TRIANGLE | aiPrimitiveType_POLYGON;
    if ((mesh.mPrimitiveTypes & kFaces) == 0) {
      result_.report.points_and_lines += mesh.mNumFaces;
      return;
    }
    Scene& scene = result_.scene;
    const auto first = static_cast<std::uint32_t>(scene.mesh.positions.size());
    const std::string mesh_name = mesh.mName.length > 0 ? mesh.mName.C_Str() : node.mName.C_Str();
    const bool coloured = mesh.HasVertexColors(0) && !mesh.HasTextureCoords(0);
    const std::uint32_t material = material_of(mesh, mesh_name, node.mName.C_Str(), coloured);
    scene.instances.push_back({.name = one_line(mesh_name), .kind = InstanceKind::structure});
    aiMatrix3x3 normal_matrix(world);
    const bool mirrored = normal_matrix.Determinant() < 0.0F;
    normal_matrix.Inverse().Transpose();
    for (unsigned int i = 0; i < mesh.mNumVertices; ++i) {
      scene.mesh.positions.push_back(to_ours(world * mesh.mVertices[i], unit_m_));
      const aiVector3D normal =
          mesh.HasNormals() ? normal_matrix * mesh.mNormals[i] : aiVector3D(0.0F, 0.0F, 0.0F);
      scene.mesh.normals.push_back(to_ours(normal, 1.0));
      scene.mesh.uvs.push_back(uv_of(mesh, i));
    }
    for (unsigned int i = 0; i < mesh.mNumFaces; ++i) {
      std::vector<std::uint32_t> polygon;
      if (mesh.mFaces[i].mNumIndices < 3) ++result_.report.points_and_lines;
      for (unsigned int j = 0; j < mesh.mFaces[i].mNumIndices; ++j) {
        EARPOINT_CHECK(mesh.mFaces[i].mIndices[j] < mesh.mNumVertices);
        polygon.push_back(first + mesh.mFaces[i].mIndices[j]);
      }
      if (mirrored) std::reverse(polygon.begin(), polygon.end());
      if (coloured) split_corners(mesh, first, polygon);
      add_polygon(polygon, material);
    }
  }

  void add_polygon(const std::vector<std::uint32_t>& polygon, std::uint32_t material) {
    Scene& scene = result_.scene;
    std::vector<Vector3> corners;
    corners.reserve(polygon.size());
    for (const std::uint32_t v : polygon) corners.push_back(vertex(scene.mesh, v));
    for (const auto& [a, b, c] : triangulate(corners)) {
      scene.mesh.triangles.push_back({polygon[a], polygon[b], polygon[c]});
      scene.mesh.triangle_material.push_back(material);
      scene.mesh.triangle_instance.push_back(
          static_cast<std::uint32_t>(scene.instances.size() - 1));
    }
  }

  [[nodiscard]] std::array<float, 3> to_ours(const aiVector3D& v, double scale) const {
    return to_our_frame({v.x, v.y, v.z}, up_axis_, scale);
  }

  static std::array<float, 2> uv_of(const aiMesh& mesh, unsigned int vertex) {
    if (!mesh.HasTextureCoords(0)) return {0.0F, 0.0F};
    const aiVector3D& uv = mesh.mTextureCoords[0][vertex];
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) return {0.0F, 0.0F};
    return {uv.x, uv.y};
  }

  /// One material for each pair of a material of the file and an acoustic material.
  std::uint32_t material_of(const aiMesh& mesh, const std::string& mesh_name,
                            const std::string& node_name, bool coloured) {
    const aiMaterial& source = *source_.mMaterials[mesh.mMaterialIndex];
    const std::string name = source.GetName().C_Str();
    MaterialTable::Match sound = table_.match(name);
    // A surface without a material is named after its mesh, not by Assimp's default name.
    std::string surface = name == AI_DEFAULT_MATERIAL_NAME && !mesh_name.empty() ? mesh_name : name;
    for (const std::string& other : {mesh_name, node_name}) {
      if (!sound.is_default) break;
      sound = table_.match(other);
      if (!sound.is_default) surface = other;
    }
    surface = one_line(surface);
    result_.report.sounds[surface] = sound.material->name;
    if (sound.is_default) result_.report.unknown_surfaces[surface] += mesh.mNumFaces;
    const std::string key =
        fmt::format("{}/{}/{}", mesh.mMaterialIndex, sound.material->name, coloured);
    const auto known = materials_.find(key);
    if (known != materials_.end()) return known->second;
    Material material{.acoustic = *sound.material, .look = look_of(source, textures_)};
    if (coloured) {
      material.look.base_colour = {1.0F, 1.0F, 1.0F};
      material.look.texture = kPalette;
    }
    const auto index = static_cast<std::uint32_t>(result_.scene.materials.size());
    result_.scene.materials.push_back(material);
    materials_.emplace(key, index);
    return index;
  }

  /// Gives a face its own corners, with the texture coordinates of one pixel that has their mean
  /// colour.
  void split_corners(const aiMesh& mesh, std::uint32_t first, std::vector<std::uint32_t>& polygon) {
    aiColor4D sum(0.0F, 0.0F, 0.0F, 0.0F);
    for (const std::uint32_t v : polygon) sum += mesh.mColors[0][v - first];
    const auto n = static_cast<float>(polygon.size());
    const std::uint32_t pixel = palette_.add(colour_of({sum.r / n, sum.g / n, sum.b / n}));
    Mesh& target = result_.scene.mesh;
    for (std::uint32_t& corner : polygon) {
      target.positions.push_back(target.positions[corner]);
      target.normals.push_back(target.normals[corner]);
      target.uvs.push_back({0.0F, 0.0F});
      corner = static_cast<std::uint32_t>(target.positions.size() - 1);
      palette_corners_.emplace_back(corner, pixel);
    }
  }

  void store_palette() {
    if (palette_.empty()) return;
    for (const auto& [corner, pixel] : palette_corners_) {
      result_.scene.mesh.uvs[corner] = palette_.uv(pixel);
    }
    const auto index = static_cast<int>(result_.scene.textures.size());
    result_.scene.textures.push_back(palette_.texture());
    for (Material& material : result_.scene.materials) {
      if (material.look.texture == kPalette) material.look.texture = index;
    }
  }

  static constexpr int kPalette = -2;  ///< until the palette is stored

  const aiScene& source_;
  const MaterialTable& table_;
  ImportedScene result_;
  TextureStore textures_;
  UpAxis up_axis_;
  double unit_m_;
  std::map<std::string, std::uint32_t> materials_;
  ColourPalette palette_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> palette_corners_;
};

/// The JSON of a glTF file; nothing if it has none where it should be.
std::optional<std::string> gltf_json(const std::filesystem::path& path) {
  std::string text = read_text_file(path);
  if (!text.starts_with("glTF")) return text;
  // A binary file: 12 bytes of header, then the JSON's length and kind.
  constexpr std::size_t kJsonStart = 20;
  if (text.size() < kJsonStart) return std::nullopt;
  std::uint32_t length = 0;
  std::memcpy(&length, text.data() + 12, sizeof length);
  if (length > text.size() - kJsonStart) return std::nullopt;
  return text.substr(kJsonStart, length);
}

/// Refuses glTF files that would crash Assimp.
/// @return its JSON
nlohmann::json check_gltf(const std::filesystem::path& path) {
  const std::optional<std::string> text = gltf_json(path);
  auto json = nlohmann::json::parse(text.value_or(""), nullptr, false);
  if (json.is_discarded() || !json.is_object()) {
    throw InputError(path.string(), "is damaged: its JSON cannot be read", kHint);
  }
  const auto images = json.find("images");
  if (images == json.end() || !images->is_array()) return json;
  for (std::size_t i = 0; i < images->size(); ++i) {
    const auto& image = (*images)[i];
    if (!image.is_object() || !image.contains("mimeType")) continue;
    const auto& kind = image["mimeType"];
    if (kind.is_string() && kind.get<std::string>().find('/') != std::string::npos) continue;
    throw InputError(
        fmt::format("{}: images[{}].mimeType", path.string(), i),
        fmt::format("expected a kind like 'image/png', found '{}'",
                    kind.is_string() ? one_line(kind.get<std::string>()) : kind.type_name()));
  }
  return json;
}

}  // namespace

ImportedScene read_with_assimp(const std::filesystem::path& path, const ImportOptions& options,
                               UpAxis up_axis) {
  unsigned int steps = kSteps;
  std::optional<std::vector<std::byte>> floats;
  if (path.extension() != ".obj" && path.extension() != ".OBJ") {
    floats = gltf_with_floats(path, check_gltf(path));
    steps |= aiProcess_ValidateDataStructure;  // too strict for OBJ: it refuses stray lines
  }
  Assimp::Importer importer;
  const aiScene* source = nullptr;
  std::string problem;
  try {
    source = floats ? importer.ReadFileFromMemory(floats->data(), floats->size(), steps, "glb")
                    : importer.ReadFile(path.string(), steps);
    problem = importer.GetErrorString();
  } catch (const std::exception& error) {
    problem = error.what();
  }
  if (source == nullptr) {
    throw InputError(path.string(), fmt::format("cannot be read as a model: {}", one_line(problem)),
                     kHint);
  }
  return AssimpReader(*source, path, options, up_axis).read();
}

}  // namespace earpoint
