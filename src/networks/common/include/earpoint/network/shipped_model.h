#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

namespace earpoint {

/// Where a weight file that comes with the program lies, e.g. "rt60.safetensors". Looked for in
/// the folder that EARPOINT_MODELS_DIR names, if it is set; otherwise in `models/` and
/// `share/earpoint/models/` beside or above the running program: what is installed under one
/// prefix, or built within the source tree, belongs together. Last in the folder that this build
/// installs them into, for programs elsewhere that use the library.
/// @return nothing if there is no such file
[[nodiscard]] std::optional<std::filesystem::path> shipped_model_path(std::string_view file_name);

/// The same for a program that lies at `program`.
[[nodiscard]] std::optional<std::filesystem::path> shipped_model_path(
    std::string_view file_name, const std::filesystem::path& program);

/// The folders that are searched for it, the first first; some may not exist.
[[nodiscard]] std::vector<std::filesystem::path> model_folders(
    const std::filesystem::path& program);

}  // namespace earpoint
