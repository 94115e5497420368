#pragma once

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace earpoint {

/// The model that is rendered with where none is named.
inline constexpr std::string_view kDefaultModel = "gtf";

/// The weight file that a user's word means: a file of that path, or else the shipped model of that
/// name.
/// @return nothing if it is neither
[[nodiscard]] std::optional<std::filesystem::path> find_model(const std::string& name_or_file);

/// The shipped model of that name, e.g. "gtf"; a file of that path does not count.
[[nodiscard]] std::optional<std::filesystem::path> shipped_model(std::string_view name);

/// What a user's word means to render with: `input` and `dsp`, which need no weight file, stay as
/// they are; a name becomes its file (find_model()). No word means the default model, or `dsp`
/// where none is shipped. A word that means nothing stays as it is: make_synthesizer() refuses it.
[[nodiscard]] std::string resolve_model(const std::string& word);

/// The names of all shipped models, sorted: of every family, NAME and NAME-*.
/// @param families  e.g. "gtf"; one that is not shipped under its own name counts as empty
[[nodiscard]] std::vector<std::string> shipped_model_names(
    std::initializer_list<std::string_view> families);

/// The names of all shipped weight files, sorted.
[[nodiscard]] std::vector<std::string> shipped_model_names();

}  // namespace earpoint
