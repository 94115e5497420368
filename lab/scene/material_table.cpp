#include <earpoint/scene/material_table.h>

#include "standard_materials_json.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/core/json_field.h>
#include <earpoint/core/strict_json.h>
#include <earpoint/error.h>

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

/// Reads 6, 7 or 8 numbers; missing bands take the nearest.
BandArray read_bands(const JsonField& field, double low, double high) {
  const Json& json = field.json();
  if (!json.is_array() || json.size() < 6 || json.size() > kOctaveBands) {
    field.refuse(fmt::format("expected 6, 7 or 8 numbers, found {}",
                             json.is_array() ? std::to_string(json.size()) : json.type_name()),
                 "6 are 125 to 4000 Hz, 7 are 125 to 8000 Hz, 8 are 62.5 to 8000 Hz");
  }
  BandArray bands{};
  const std::size_t first_band = json.size() == kOctaveBands ? 0 : 1;
  const std::vector<JsonField> entries = field.items();
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const double value = json[i].is_number() ? json[i].get<double>() : NAN;
    if (!(value >= low && value <= high)) {
      entries[i].fail(fmt::format("a number in [{}, {}]", low, high));
    }
    bands[first_band + i] = static_cast<float>(value);
  }
  const std::size_t last_band = first_band + json.size() - 1;
  if (first_band == 1) bands[0] = bands[1];
  for (std::size_t band = last_band + 1; band < kOctaveBands; ++band)
    bands[band] = bands[last_band];
  return bands;
}

AcousticMaterial read_material(const std::string& name, const JsonField& field) {
  field.expect_only({"absorption", "absorption_source", "scattering", "scattering_source",
                     "transmission_loss_db", "transmission_source"});
  AcousticMaterial material;
  material.name = name;
  material.absorption = read_bands(field.field("absorption"), 0.0, 1.0);
  material.scattering = read_bands(field.field("scattering"), 0.0, 1.0);
  if (field.has("transmission_loss_db")) {
    const JsonField loss = field.field("transmission_loss_db");
    const BandArray loss_db = read_bands(loss, 0.0, 200.0);
    for (std::size_t band = 0; band < kOctaveBands; ++band) {
      material.transmission[band] = std::pow(10.0F, -0.1F * loss_db[band]);
      if (material.transmission[band] <= material.absorption[band]) continue;
      loss.refuse(
          fmt::format("transmits {:.3f} at {} Hz, but absorbs only {}", material.transmission[band],
                      kOctaveBandCentresHz[band], material.absorption[band]),
          "absorption includes transmission");
    }
  }
  for (const char* key : {"absorption_source", "scattering_source", "transmission_source"}) {
    if (!field.has(key)) continue;
    material.source +=
        fmt::format("{}{}", material.source.empty() ? "" : " | ", field.field(key).text());
  }
  return material;
}

}  // namespace

/// Builds a table from JSON, field by field.
class MaterialTableReader {
 public:
  explicit MaterialTableReader(JsonField top) : top_(std::move(top)) {}

  MaterialTable read() {
    top_.expect_only({"format", "references", "default", "materials", "patterns", "extends"});
    const std::string format = top_.field("format").text();
    if (format != kFormat) {
      top_.field("format").refuse(fmt::format("expected '{}', found '{}'", kFormat, format));
    }
    if (top_.has("references")) {
      for (const auto& [key, reference] : top_.field("references").fields()) {
        static_cast<void>(reference.text());
      }
    }
    if (top_.has("extends")) {
      const std::string base = top_.field("extends").text();
      if (base != "standard") {
        top_.field("extends").refuse(fmt::format("expected 'standard', found '{}'", base));
      }
      base_ = &standard_materials();
    }
    read_materials();
    read_patterns();
    read_default();
    return std::move(table_);
  }

 private:
  void read_materials() {
    if (base_ == nullptr || top_.has("materials")) {
      for (const auto& [name, material] : top_.field("materials").fields()) {
        table_.materials_.push_back(read_material(name, material));
      }
    }
    if (base_ != nullptr) {
      for (const AcousticMaterial& material : base_->materials()) {
        if (table_.find(material.name) == nullptr) table_.materials_.push_back(material);
      }
    }
    if (table_.materials_.empty()) {
      top_.field("materials").refuse("is empty", "give at least the default material");
    }
  }

  void read_patterns() {
    if (top_.has("patterns")) {
      for (const JsonField& pattern : top_.field("patterns").items()) read_pattern(pattern);
    }
    if (base_ != nullptr) table_.take_patterns_behind(*base_);
  }

  void read_pattern(const JsonField& field) {
    field.expect_only({"material", "words"});
    const std::size_t material = index_of(field.field("material"));
    for (const JsonField& words : field.field("words").items()) {
      const std::string text = words.text();
      std::vector<std::string> parts = words_of(text);
      if (parts.empty()) words.refuse(fmt::format("'{}' has no letters", text));
      for (const std::string& part : parts) {
        const std::size_t star = part.find('*');
        if (star == std::string::npos || (star > 0 && star + 1 == part.size())) continue;
        words.refuse(fmt::format("'{}' has a * that is not at the end of a word", text));
      }
      table_.patterns_.push_back({.words = std::move(parts), .material = material, .rank = 0});
    }
  }

  void read_default() {
    if (base_ != nullptr && !top_.has("default")) {
      table_.default_material_ = position(base_->materials_[base_->default_material_].name).value();
      return;
    }
    table_.default_material_ = index_of(top_.field("default"));
  }

  std::size_t index_of(const JsonField& field) {
    const std::string name = field.text();
    const auto index = position(name);
    if (!index) field.refuse(fmt::format("names '{}', which is not in 'materials'", name));
    return *index;
  }

  [[nodiscard]] std::optional<std::size_t> position(std::string_view name) const {
    const AcousticMaterial* found = table_.find(name);
    if (found == nullptr) return std::nullopt;
    return static_cast<std::size_t>(found - table_.materials_.data());
  }

  JsonField top_;
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
  constexpr int kDepth = 8;
  const Json document = parse_strict_json(json, where, kDepth);
  return MaterialTableReader(JsonField(document, std::string(where))).read();
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
