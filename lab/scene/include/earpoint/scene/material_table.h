#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/scene/material.h>

namespace earpoint {

/// Acoustic materials by name, and patterns that find one for whatever a model calls its surfaces.
///
/// A pattern is one or more words. A surface's name is cut into lower-case words at everything that
/// is not a letter, and where a small letter meets a capital: "Wall_03.Plaster" and "wallPlaster"
/// both read "wall plaster". A pattern matches where its words stand one after the other; `*` at
/// the end of a word stands for any letters. Of all patterns that match, the one with the most
/// words wins, then the first.
class MaterialTable {
 public:
  struct Match {
    const AcousticMaterial* material = nullptr;  ///< never null; owned by the table
    bool is_default = false;                     ///< no pattern matched
  };

  /// Reads a table from JSON, as docs/formats.md describes it: `materials` with octave-band
  /// absorption and scattering (6 numbers are 125 to 4000 Hz, 7 are 125 to 8000 Hz, 8 are 62.5 to
  /// 8000 Hz; missing bands take the nearest number), `patterns`, `default`, and optionally
  /// `"extends": "standard"`, which puts the standard table behind this one.
  /// @param where  what errors call the text, e.g. its file
  /// @throws InputError naming the first field that is unknown, missing or out of range
  static MaterialTable parse(std::string_view json, std::string_view where);

  /// @return the material of that very name, or null
  [[nodiscard]] const AcousticMaterial* find(std::string_view name) const;

  /// @return the material for a surface called `surface_name`, the default if no pattern matches
  [[nodiscard]] Match match(std::string_view surface_name) const;

  [[nodiscard]] const std::vector<AcousticMaterial>& materials() const { return materials_; }

 private:
  struct Pattern {
    std::vector<std::string> words;
    std::size_t material = 0;
    int rank = 0;  ///< of the table that it comes from: the lowest rank that matches wins
  };

  void take_patterns_behind(const MaterialTable& base);

  std::vector<AcousticMaterial> materials_;
  std::vector<Pattern> patterns_;
  std::size_t default_material_ = 0;

  friend class MaterialTableReader;
};

/// @throws InputError as MaterialTable::parse, or if the file cannot be read
MaterialTable load_material_table(const std::filesystem::path& path);

/// The table that comes with the program: some 45 surfaces of homes from published tables, and
/// patterns for the categories of Matterport3D, Replica and Gibson. Every row has its source.
const MaterialTable& standard_materials();

/// @return the standard material of that name
/// @throws std::logic_error if there is none
const AcousticMaterial& standard_material(std::string_view name);

}  // namespace earpoint
