#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <earpoint/scene/furniture.h>
#include <earpoint/scene/people.h>

namespace earpoint {

/// Furniture and figures, ready to be placed.
struct ModelPack {
  std::vector<FurnitureModel> furniture;
  std::vector<FigureModel> figures;
};

/// Writes a pack as one file: a line of JSON that describes it, then the numbers. docs/formats.md
/// has the layout.
/// @throws InputError if it cannot be written
void write_model_pack(const ModelPack& pack, const std::filesystem::path& path);

/// @throws InputError if the file is missing, of another version, damaged or cut short
ModelPack read_model_pack(const std::filesystem::path& path);

/// Where `./dev assets` puts the pack: $EARPOINT_DATA_DIR, else $XDG_DATA_HOME/earpoint, else
/// ~/.local/share/earpoint.
/// @return the pack's path if it is there
std::optional<std::filesystem::path> installed_model_pack();

/// @return the installed pack, or an empty one, with which libraries use their stand-ins
/// @throws InputError if a pack is there, but damaged
ModelPack installed_models();

/// What people should know of homes that are made with these models, in one line; empty if the
/// models are there.
[[nodiscard]] std::string warning_of(const ModelPack& models);

}  // namespace earpoint
