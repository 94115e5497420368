#include <earpoint/scene/material_table.h>

#include "standard_materials_json.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/error.h>
#include <earpoint/core/file.h>

namespace earpoint {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kFormat = "earpoint-materials-1";
constexpr std::size_t kLongestTable_bytes = 16 << 20;

/// Cuts a name into words, as MaterialTable describes it; a `*` belongs to its word.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words;
  bool in_word = false;
  bool after_small = false;
  for (const char raw : name) {
    const auto letter = static_cast<unsigned char>(raw);
    const bool is_letter = std::isalpha(letter) != 0 || raw == '*';
    const bool is_capital = std::isupper(letter) != 0;
    if (is_letter) {
      if (!in_word || (after_small && is_capital)) words.emplace_back();
      words.back().push_back(static_cast<char>(std::tolower(letter)));
    }
    in_word = is_letter;
    after_small = is_letter && !is_capital;
  }
  return words;
}

bool word_matches(std::string_view pattern, std::string_view word) {
  if (!pattern.ends_with('*')) return pattern == word;
  pattern.remove_suffix(1);
  return word.starts_with(pattern);
}

bool words_match(const std::vector<std::string>& pattern, const std::vector<std::string>& name) {
  if (pattern.size() > name.size()) return false;
  for (std::size_t start = 0; start + pattern.size() <= name.size(); ++start) {
    if (std::equal(pattern.begin(), pattern.end(),
                   name.begin() + static_cast<std::ptrdiff_t>(start), word_matches)) {
      return true;
    }
  }
  return false;
}

/// A position in the table, for messages: "materials.json: materials.plaster.absorption".
class Field {
 public:
  Field(std::string_view where, std::string path) : where_(where), path_(std::move(path)) {}

  [[nodiscard]] Field at(std::string_view key) const {
    return {where_, path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key)};
  }
  [[nodiscard]] Field at(std::size_t index) const {
    return {where_, fmt::format("{}[{}]", path_, index)};
  }
  [[noreturn]] void fail(const std::string& problem, std::string_view hint = {}) const {
    throw InputError(path_.empty() ? where_ : fmt::format("{}: {}", where_, path_), problem, hint);
  }

 private:
  std::string where_;
  std::string path_;
};

void expect_object(const Json& json, const Field& field, const std::set<std::string>& known) {
  if (!json.is_object()) field.fail(fmt::format("expected an object, found {}", json.type_name()));
  for (const auto& [key, value] : json.items()) {
    if (known.contains(key)) continue;
    field.fail(fmt::format("has an unknown key '{}'", key),
               fmt::format("known keys: {}", fmt::join(known, ", ")));
  }
}

const Json& expect_key(const Json& json, const Field& field, const char* key) {
  const auto found = json.find(key);
  if (found == json.end()) field.fail(fmt::format("has no '{}'", key));
  return *found;
}

std::string read_string(const Json& json, const Field& field) {
  if (!json.is_string()) field.fail(fmt::format("expected a text, found {}", json.type_name()));
  return json.get<std::string>();
}

/// Reads 6, 7 or 8 numbers; bands beyond the given ones take the nearest.
BandArray read_bands(const Json& json, const Field& field, double low, double high) {
  if (!json.is_array() || json.size() < 6 || json.size() > kOctaveBands) {
    field.fail(fmt::format("expected 6, 7 or 8 numbers, found {}",
                           json.is_array() ? std::to_string(json.size()) : json.type_name()),
               "6 are 125 to 4000 Hz, 7 are 125 to 8000 Hz, 8 are 62.5 to 8000 Hz");
  }
  BandArray bands{};
  const std::size_t first_band = json.size() == kOctaveBands ? 0 : 1;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const Json& entry = json[i];
    const double value = entry.is_number() ? entry.get<double>() : NAN;
    if (!(value >= low && value <= high)) {
      field.at(i).fail(
          fmt::format("expected a number in [{}, {}], found {}", low, high, entry.dump()));
    }
    bands[first_band + i] = static_cast<float>(value);
  }
  const std::size_t last_band = first_band + json.size() - 1;
  if (first_band == 1) bands[0] = bands[1];
  for (std::size_t band = last_band + 1; band < kOctaveBands; ++band)
    bands[band] = bands[last_band];
  return bands;
}

AcousticMaterial read_material(const std::string& name, const Json& json, const Field& field) {
  expect_object(json, field,
                {"absorption", "absorption_source", "scattering", "scattering_source",
                 "transmission_loss_db", "transmission_source"});
  AcousticMaterial material;
  material.name = name;
  material.absorption =
      read_bands(expect_key(json, field, "absorption"), field.at("absorption"), 0.0, 1.0);
  material.scattering =
      read_bands(expect_key(json, field, "scattering"), field.at("scattering"), 0.0, 1.0);
  if (json.contains("transmission_loss_db")) {
    const Field loss_field = field.at("transmission_loss_db");
    const BandArray loss_db = read_bands(json["transmission_loss_db"], loss_field, 0.0, 200.0);
    for (std::size_t band = 0; band < kOctaveBands; ++band) {
      material.transmission[band] = std::pow(10.0F, -0.1F * loss_db[band]);
      if (material.transmission[band] <= material.absorption[band]) continue;
      loss_field.fail(
          fmt::format("transmits {:.3f} at {} Hz, but absorbs only {}", material.transmission[band],
                      kOctaveBandCentresHz[band], material.absorption[band]),
          "absorption includes transmission");
    }
  }
  for (const char* key : {"absorption_source", "scattering_source", "transmission_source"}) {
    if (!json.contains(key)) continue;
    const std::string text = read_string(json[key], field.at(key));
    material.source += fmt::format("{}{}", material.source.empty() ? "" : " | ", text);
  }
  return material;
}

/// Parses JSON and refuses a key that occurs twice in one object: one of the two would be lost.
Json parse_json(std::string_view text, std::string_view where) {
  std::vector<std::set<std::string>> keys;
  std::string twice;
  const auto watch = [&](int, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key &&
        !keys.back().insert(parsed.get<std::string>()).second && twice.empty()) {
      twice = parsed.get<std::string>();
    }
    return true;
  };
  Json document;
  try {
    document = Json::parse(text, watch);
  } catch (const Json::exception& error) {
    std::string problem = error.what();
    std::replace_if(
        problem.begin(), problem.end(),
        [](char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0; }, ' ');
    throw InputError(where, fmt::format("is not JSON: {}", problem));
  }
  if (!twice.empty()) {
    throw InputError(where, fmt::format("has the key '{}' twice in one object", twice),
                     "keep one of them");
  }
  return document;
}

}  // namespace

/// Builds a table from JSON, field by field.
class MaterialTableReader {
 public:
  MaterialTableReader(const Json& json, std::string_view where) : json_(json), top_(where, "") {}

  MaterialTable read() {
    expect_object(json_, top_,
                  {"format", "references", "default", "materials", "patterns", "extends"});
    const std::string format = read_string(expect_key(json_, top_, "format"), top_.at("format"));
    if (format != kFormat) {
      top_.at("format").fail(fmt::format("expected '{}', found '{}'", kFormat, format));
    }
    read_references();
    if (json_.contains("extends")) {
      const std::string base = read_string(json_["extends"], top_.at("extends"));
      if (base != "standard") {
        top_.at("extends").fail(fmt::format("expected 'standard', found '{}'", base));
      }
      base_ = &standard_materials();
    }
    read_materials();
    read_patterns();
    read_default();
    return std::move(table_);
  }

 private:
  void read_references() {
    if (!json_.contains("references")) return;
    const Field field = top_.at("references");
    if (!json_["references"].is_object()) field.fail("expected an object of texts");
    for (const auto& [key, value] : json_["references"].items()) read_string(value, field.at(key));
  }

  void read_materials() {
    const Json empty = Json::object();
    const Json& rows = base_ != nullptr && !json_.contains("materials")
                           ? empty
                           : expect_key(json_, top_, "materials");
    const Field field = top_.at("materials");
    if (!rows.is_object())
      field.fail(fmt::format("expected an object, found {}", rows.type_name()));
    for (const auto& [name, row] : rows.items()) {
      table_.materials_.push_back(read_material(name, row, field.at(name)));
    }
    if (base_ != nullptr) {
      for (const AcousticMaterial& material : base_->materials()) {
        if (table_.find(material.name) == nullptr) table_.materials_.push_back(material);
      }
    }
    if (table_.materials_.empty()) field.fail("is empty", "give at least the default material");
  }

  void read_patterns() {
    if (json_.contains("patterns")) {
      const Json& rows = json_["patterns"];
      const Field field = top_.at("patterns");
      if (!rows.is_array()) field.fail(fmt::format("expected a list, found {}", rows.type_name()));
      for (std::size_t i = 0; i < rows.size(); ++i) read_pattern(rows[i], field.at(i));
    }
    if (base_ != nullptr) table_.take_patterns_behind(*base_);
  }

  void read_pattern(const Json& row, const Field& field) {
    expect_object(row, field, {"material", "words"});
    const std::size_t material = index_of(expect_key(row, field, "material"), field.at("material"));
    const Json& words = expect_key(row, field, "words");
    if (!words.is_array()) {
      field.at("words").fail(fmt::format("expected a list, found {}", words.type_name()));
    }
    for (std::size_t i = 0; i < words.size(); ++i) {
      const Field place = field.at("words").at(i);
      const std::string text = read_string(words[i], place);
      std::vector<std::string> parts = words_of(text);
      if (parts.empty()) place.fail(fmt::format("'{}' has no letters", text));
      for (const std::string& part : parts) {
        const std::size_t star = part.find('*');
        if (star == std::string::npos || (star > 0 && star + 1 == part.size())) continue;
        place.fail(fmt::format("'{}' has a * that is not at the end of a word", text));
      }
      table_.patterns_.push_back({.words = std::move(parts), .material = material, .rank = 0});
    }
  }

  void read_default() {
    if (base_ != nullptr && !json_.contains("default")) {
      table_.default_material_ = position(base_->materials_[base_->default_material_].name).value();
      return;
    }
    table_.default_material_ = index_of(expect_key(json_, top_, "default"), top_.at("default"));
  }

  std::size_t index_of(const Json& json, const Field& field) {
    const std::string name = read_string(json, field);
    const auto index = position(name);
    if (!index) field.fail(fmt::format("names '{}', which is not in 'materials'", name));
    return *index;
  }

  [[nodiscard]] std::optional<std::size_t> position(std::string_view name) const {
    const AcousticMaterial* found = table_.find(name);
    if (found == nullptr) return std::nullopt;
    return static_cast<std::size_t>(found - table_.materials_.data());
  }

  const Json& json_;
  Field top_;
  const MaterialTable* base_ = nullptr;
  MaterialTable table_;
};

void MaterialTable::take_patterns_behind(const MaterialTable& base) {
  for (Pattern pattern : base.patterns_) {
    const AcousticMaterial* material = find(base.materials_[pattern.material].name);
    pattern.material = static_cast<std::size_t>(material - materials_.data());
    pattern.rank += 1;
    patterns_.push_back(std::move(pattern));
  }
}

MaterialTable MaterialTable::parse(std::string_view json, std::string_view where) {
  if (json.size() > kLongestTable_bytes) {
    throw InputError(where, fmt::format("is {} bytes long, expected at most {}", json.size(),
                                        kLongestTable_bytes));
  }
  const Json document = parse_json(json, where);
  return MaterialTableReader(document, where).read();
}

const AcousticMaterial* MaterialTable::find(std::string_view name) const {
  const auto found =
      std::find_if(materials_.begin(), materials_.end(),
                   [&](const AcousticMaterial& material) { return material.name == name; });
  return found == materials_.end() ? nullptr : &*found;
}

MaterialTable::Match MaterialTable::match(std::string_view surface_name) const {
  const std::vector<std::string> name = words_of(surface_name);
  const Pattern* best = nullptr;
  for (const Pattern& pattern : patterns_) {
    if (!words_match(pattern.words, name)) continue;
    const bool wins = best == nullptr || pattern.rank < best->rank ||
                      (pattern.rank == best->rank && pattern.words.size() > best->words.size());
    if (wins) best = &pattern;
  }
  if (best == nullptr) return {.material = &materials_[default_material_], .is_default = true};
  return {.material = &materials_[best->material], .is_default = false};
}

MaterialTable load_material_table(const std::filesystem::path& path) {
  return MaterialTable::parse(read_text_file(path), path.string());
}

const MaterialTable& standard_materials() {
  static const MaterialTable table = MaterialTable::parse(kStandardMaterialsJson, "materials.json");
  return table;
}

const AcousticMaterial& standard_material(std::string_view name) {
  const AcousticMaterial* found = standard_materials().find(name);
  EARPOINT_CHECK(found != nullptr);
  return *found;
}

}  // namespace earpoint
