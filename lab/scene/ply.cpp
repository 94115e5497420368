#include "ply.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>

#include <fmt/core.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

enum class Encoding { ascii, little_endian, big_endian };

struct NumberType {
  std::size_t bytes = 0;
  bool is_float = false;
  bool is_signed = false;
};

std::optional<NumberType> number_type(const std::string& name) {
  static const std::map<std::string, NumberType> types = {
      {"char", {1, false, true}},    {"int8", {1, false, true}},    {"uchar", {1, false, false}},
      {"uint8", {1, false, false}},  {"short", {2, false, true}},   {"int16", {2, false, true}},
      {"ushort", {2, false, false}}, {"uint16", {2, false, false}}, {"int", {4, false, true}},
      {"int32", {4, false, true}},   {"uint", {4, false, false}},   {"uint32", {4, false, false}},
      {"float", {4, true, true}},    {"float32", {4, true, true}},  {"double", {8, true, true}},
      {"float64", {8, true, true}}};
  const auto found = types.find(name);
  if (found == types.end()) return std::nullopt;
  return found->second;
}

// Indices of the numbers of a vertex.
constexpr std::size_t kPosition = 0;
constexpr std::size_t kNormal = 3;
constexpr std::size_t kColour = 6;
constexpr std::size_t kTexture = 9;
constexpr std::size_t kSlots = 11;
constexpr std::size_t kNoSlot = kSlots;

std::size_t slot_of(const std::string& name) {
  static const std::map<std::string, std::size_t> slots = {
      {"x", kPosition},    {"y", kPosition + 1},    {"z", kPosition + 2},
      {"nx", kNormal},     {"ny", kNormal + 1},     {"nz", kNormal + 2},
      {"red", kColour},    {"green", kColour + 1},  {"blue", kColour + 2},
      {"s", kTexture},     {"t", kTexture + 1},     {"u", kTexture},
      {"v", kTexture + 1}, {"texture_u", kTexture}, {"texture_v", kTexture + 1}};
  const auto found = slots.find(name);
  return found == slots.end() ? kNoSlot : found->second;
}

struct Property {
  std::string name;
  NumberType type;
  std::optional<NumberType> count_type;  ///< of lists
  std::size_t slot = kNoSlot;            ///< in a vertex
  double scale = 1.0;
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

class PlyReader {
 public:
  explicit PlyReader(const std::filesystem::path& path)
      : where_(path.string()), text_(read_text_file(path)) {}

  PlyModel read() {
    read_header();
    for (const Element& element : elements_) read_element(element);
    for (const auto& polygon : model_.polygons) {
      for (const std::uint32_t v : polygon) {
        if (v < model_.positions.size()) continue;
        fail(fmt::format("a face has vertex {}, but there are {}", v, model_.positions.size()));
      }
    }
    return std::move(model_);
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw InputError(where_, problem, "export it again");
  }

  std::string next_line() {
    const std::size_t end = text_.find('\n', at_);
    if (end == std::string::npos) fail("is truncated in its header");
    std::string line = text_.substr(at_, end - at_);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    at_ = end + 1;
    return line;
  }

  void read_header() {
    if (!text_.starts_with("ply")) fail("does not begin with 'ply'");
    next_line();
    for (;;) {
      std::istringstream words(next_line());
      std::string keyword;
      words >> keyword;
      if (keyword == "end_header") break;
      if (keyword == "format") {
        std::string name;
        words >> name;
        read_format(name);
      } else if (keyword == "element") {
        Element element;
        words >> element.name >> element.count;
        if (!words) fail("has an element without name and count");
        elements_.push_back(element);
      } else if (keyword == "property") {
        read_property(words);
      } else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
        fail(fmt::format("has an unknown line '{}' in its header", keyword));
      }
    }
    if (!has_format_) fail("names no format");
  }

  void read_format(const std::string& name) {
    has_format_ = true;
    if (name == "ascii") {
      encoding_ = Encoding::ascii;
    } else if (name == "binary_little_endian") {
      encoding_ = Encoding::little_endian;
    } else if (name == "binary_big_endian") {
      encoding_ = Encoding::big_endian;
    } else {
      fail(fmt::format("has an unknown format '{}'", name));
    }
  }

  void read_property(std::istringstream& words) {
    if (elements_.empty()) fail("has a property before any element");
    Property property;
    std::string type;
    words >> type;
    if (type == "list") {
      std::string count_type;
      words >> count_type >> type;
      property.count_type = number_type(count_type);
      if (!property.count_type || property.count_type->is_float) {
        fail(fmt::format("has a list with counts of type '{}'", count_type));
      }
    }
    const auto known = number_type(type);
    words >> property.name;
    if (!known || !words) fail(fmt::format("has a property of an unknown type '{}'", type));
    property.type = *known;
    property.slot = slot_of(property.name);
    const bool is_colour = property.slot >= kColour && property.slot < kTexture;
    if (is_colour && !known->is_float) property.scale = 1.0 / (known->bytes == 1 ? 255.0 : 65535.0);
    elements_.back().properties.push_back(property);
  }

  /// The next number of the body, whatever its type.
  double number(const NumberType& type) {
    return encoding_ == Encoding::ascii ? ascii_number() : binary_number(type);
  }

  double ascii_number() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
    if (at_ >= text_.size()) fail("is truncated");
    double value = 0.0;
    const char* begin = text_.data() + at_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
    if (error != std::errc()) fail(fmt::format("has no number at byte {}", at_));
    at_ += static_cast<std::size_t>(end - begin);
    return value;
  }

  double binary_number(const NumberType& type) {
    if (text_.size() - at_ < type.bytes) fail("is truncated");
    std::array<unsigned char, 8> bytes{};
    std::memcpy(bytes.data(), text_.data() + at_, type.bytes);
    at_ += type.bytes;
    if (encoding_ == Encoding::big_endian) {
      std::reverse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(type.bytes));
    }
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < type.bytes; ++i) bits |= std::uint64_t{bytes[i]} << (8 * i);
    if (type.is_float) {
      return type.bytes == 4 ? std::bit_cast<float>(static_cast<std::uint32_t>(bits))
                             : std::bit_cast<double>(bits);
    }
    if (!type.is_signed) return static_cast<double>(bits);
    const unsigned shift = static_cast<unsigned>(64 - 8 * type.bytes);
    return static_cast<double>(static_cast<std::int64_t>(bits << shift) >> shift);
  }

  std::uint64_t list_length(const Property& property) {
    const double count = number(*property.count_type);
    if (!(count >= 0.0) || count > static_cast<double>(text_.size())) {
      fail(fmt::format("has a list of {} entries", count));
    }
    return static_cast<std::uint64_t>(count);
  }

  void read_element(const Element& element) {
    const bool is_vertex = element.name == "vertex";
    const bool is_face = element.name == "face";
    for (std::uint64_t i = 0; i < element.count; ++i) {
      // Elements without properties have no bytes, whatever their count.
      if (element.properties.empty()) return;
      if (is_vertex) {
        read_vertex(element);
      } else {
        for (const Property& property : element.properties) read_other(property, is_face);
      }
    }
  }

  void read_vertex(const Element& element) {
    std::array<float, kSlots> values{};
    for (const Property& property : element.properties) {
      if (property.count_type) {
        read_other(property, false);
        continue;
      }
      const double value = number(property.type) * property.scale;
      if (property.slot != kNoSlot) values[property.slot] = static_cast<float>(value);
    }
    const auto has = [&](std::size_t first) {
      return std::any_of(element.properties.begin(), element.properties.end(),
                         [&](const Property& property) { return property.slot == first; });
    };
    const auto three = [&](std::size_t first) {
      return std::array<float, 3>{values[first], values[first + 1], values[first + 2]};
    };
    model_.positions.push_back(three(kPosition));
    if (has(kNormal)) model_.normals.push_back(three(kNormal));
    if (has(kColour)) model_.colours.push_back(three(kColour));
    if (has(kTexture)) model_.uvs.push_back({values[kTexture], values[kTexture + 1]});
  }

  void read_other(const Property& property, bool in_face) {
    if (!property.count_type) {
      number(property.type);
      return;
    }
    const std::uint64_t length = list_length(property);
    const bool is_polygon =
        in_face && (property.name == "vertex_indices" || property.name == "vertex_index");
    std::vector<std::uint32_t> polygon;
    for (std::uint64_t i = 0; i < length; ++i) {
      const double value = number(property.type);
      if (!is_polygon) continue;
      if (!(value >= 0.0 && value <= 4294967295.0) || value != std::floor(value)) {
        fail(fmt::format("a face has vertex {}", value));
      }
      polygon.push_back(static_cast<std::uint32_t>(value));
    }
    if (!is_polygon) return;
    if (polygon.size() < 3) {
      ++model_.small_faces;
    } else {
      model_.polygons.push_back(std::move(polygon));
    }
  }

  std::string where_;
  std::string text_;
  std::size_t at_ = 0;
  bool has_format_ = false;
  Encoding encoding_ = Encoding::ascii;
  std::vector<Element> elements_;
  PlyModel model_;
};

}  // namespace

PlyModel read_ply(const std::filesystem::path& path) { return PlyReader(path).read(); }

}  // namespace earpoint
