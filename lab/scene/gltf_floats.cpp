#include "gltf_floats.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <set>
#include <string>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

using Json = nlohmann::json;

constexpr int kFloat = 5126;
constexpr std::size_t kHeader = 12;
constexpr std::size_t kChunkHeader = 8;

std::uint32_t word_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

void append_word(std::vector<std::byte>& bytes, std::uint32_t word) {
  const auto* first = reinterpret_cast<const std::byte*>(&word);
  bytes.insert(bytes.end(), first, first + sizeof word);
}

/// The accessors of vertex attributes with integer components.
std::set<std::size_t> quantised_accessors(const Json& json) {
  std::set<std::size_t> found;
  const Json& accessors = json.at("accessors");
  for (const Json& mesh : json.at("meshes")) {
    for (const Json& primitive : mesh.at("primitives")) {
      for (const auto& [name, index] : primitive.at("attributes").items()) {
        const bool counts = name == "POSITION" || name == "NORMAL" || name == "TANGENT" ||
                            name.starts_with("TEXCOORD");
        const auto accessor = index.get<std::size_t>();
        if (counts && accessors.at(accessor).at("componentType") != kFloat) found.insert(accessor);
      }
    }
  }
  return found;
}

template <typename Integer>
float value_at(const std::byte* at, bool is_normalized) {
  Integer value{};
  std::memcpy(&value, at, sizeof value);
  if (!is_normalized) return value;
  return std::max(
      -1.0F, static_cast<float>(value) / static_cast<float>(std::numeric_limits<Integer>::max()));
}

/// The numbers of one accessor.
class Quantised {
 public:
  /// @param where  its name in errors
  Quantised(const Json& json, const Json& accessor, std::span<const std::byte> data,
            const std::string& where)
      : data_(data), kind_(accessor.at("componentType").get<int>()) {
    constexpr std::array<int, 4> kSizes = {1, 1, 2, 2};
    constexpr int kFirstKind = 5120;
    const auto type = accessor.at("type").get<std::string>();
    if (accessor.contains("sparse") || kind_ < kFirstKind || kind_ > kFirstKind + 3 ||
        !type.starts_with("VEC") || type.size() != 4) {
      throw InputError(where, "has an invalid component type for vertices", "export it again");
    }
    size_ = kSizes[kind_ - kFirstKind];
    components_ = type[3] - '0';
    is_normalized_ = accessor.value("normalized", false);
    count_ = accessor.at("count").get<std::size_t>();
    const Json& view = json.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
    const auto packed = static_cast<std::size_t>(size_) * components_;
    stride_ = view.value("byteStride", packed);
    first_ =
        view.value("byteOffset", std::size_t{0}) + accessor.value("byteOffset", std::size_t{0});
    const bool fits = view.at("buffer") == 0 && first_ <= data.size() && stride_ >= packed &&
                      (count_ == 0 || (data.size() - first_ >= packed &&
                                       (data.size() - first_ - packed) / stride_ >= count_ - 1));
    if (!fits) throw InputError(where, "points outside the file's data", "export it again");
  }

  [[nodiscard]] std::vector<float> floats() const {
    std::vector<float> values;
    values.reserve(count_ * components_);
    for (std::size_t i = 0; i < count_; ++i) {
      for (int c = 0; c < components_; ++c) {
        values.push_back(
            at(data_.data() + first_ + i * stride_ + static_cast<std::size_t>(c) * size_));
      }
    }
    return values;
  }

 private:
  [[nodiscard]] float at(const std::byte* place) const {
    switch (kind_) {
      case 5120:
        return value_at<std::int8_t>(place, is_normalized_);
      case 5121:
        return value_at<std::uint8_t>(place, is_normalized_);
      case 5122:
        return value_at<std::int16_t>(place, is_normalized_);
      default:
        return value_at<std::uint16_t>(place, is_normalized_);
    }
  }

  std::span<const std::byte> data_;
  int kind_ = 0;
  int size_ = 0;
  int components_ = 0;
  bool is_normalized_ = false;
  std::size_t count_ = 0;
  std::size_t stride_ = 0;
  std::size_t first_ = 0;
};

std::vector<std::byte> binary_file(const Json& json, const std::vector<std::byte>& data) {
  std::string text = json.dump();
  text.append((4 - text.size() % 4) % 4, ' ');
  std::vector<std::byte> file;
  constexpr std::array<std::uint32_t, 4> kWords = {0x46546C67, 2, 0x4E4F534A, 0x004E4942};
  append_word(file, kWords[0]);  // "glTF", version 2
  append_word(file, kWords[1]);
  append_word(file,
              static_cast<std::uint32_t>(kHeader + 2 * kChunkHeader + text.size() + data.size()));
  append_word(file, static_cast<std::uint32_t>(text.size()));
  append_word(file, kWords[2]);  // "JSON"
  const auto* letters = reinterpret_cast<const std::byte*>(text.data());
  file.insert(file.end(), letters, letters + text.size());
  append_word(file, static_cast<std::uint32_t>(data.size()));
  append_word(file, kWords[3]);  // "BIN"
  file.insert(file.end(), data.begin(), data.end());
  return file;
}

/// The second chunk of a binary file.
std::vector<std::byte> binary_chunk(const std::filesystem::path& path) {
  const std::vector<std::byte> file = read_file(path);
  const bool is_binary = file.size() >= kHeader + kChunkHeader && word_at(file, 0) == 0x46546C67;
  if (!is_binary) {
    throw InputError(path.string(), "has small integers as coordinates in a separate file",
                     "save it as .glb");
  }
  const std::size_t start = kHeader + 2 * kChunkHeader + word_at(file, kHeader);
  if (start > file.size()) throw InputError(path.string(), "is truncated", "export it again");
  std::vector<std::byte> data(file.begin() + static_cast<std::ptrdiff_t>(start), file.end());
  data.resize((data.size() + 3) / 4 * 4);
  return data;
}

}  // namespace

std::optional<std::vector<std::byte>> gltf_with_floats(const std::filesystem::path& path,
                                                       nlohmann::json json) try {
  for (const Json& extension : json.value("extensionsRequired", Json::array())) {
    if (extension != "EXT_meshopt_compression") continue;
    throw InputError(path.string(), "is compressed by meshopt, which is not supported",
                     "export it without compression");
  }
  if (!json.contains("meshes") || !json.contains("accessors")) return std::nullopt;
  const std::set<std::size_t> quantised = quantised_accessors(json);
  if (quantised.empty()) return std::nullopt;
  std::vector<std::byte> data = binary_chunk(path);
  const std::vector<std::byte> old_data = data;
  for (const std::size_t index : quantised) {
    Json& accessor = json["accessors"][index];
    const std::vector<float> values =
        Quantised(json, accessor, old_data, fmt::format("{}: accessors[{}]", path.string(), index))
            .floats();
    json["bufferViews"].push_back({{"buffer", 0},
                                   {"byteOffset", data.size()},
                                   {"byteLength", values.size() * sizeof(float)}});
    const auto* bytes = reinterpret_cast<const std::byte*>(values.data());
    data.insert(data.end(), bytes, bytes + values.size() * sizeof(float));
    accessor["bufferView"] = json["bufferViews"].size() - 1;
    accessor["componentType"] = kFloat;
    for (const char* key : {"byteOffset", "normalized", "min", "max"}) accessor.erase(key);
  }
  json["buffers"][0]["byteLength"] = data.size();
  return binary_file(json, data);
} catch (const Json::exception&) {
  return std::nullopt;  // damaged in a way that Assimp names
}

}  // namespace earpoint
