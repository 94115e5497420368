#include <earpoint/network/model_names.h>

#include <algorithm>
#include <set>
#include <system_error>

#include <earpoint/core/platform/program_path.h>
#include <earpoint/network/shipped_model.h>

namespace earpoint {
namespace fs = std::filesystem;

namespace {

constexpr std::string_view kExtension = ".safetensors";

/// Names of the weight files in a folder, which may not exist.
std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& file : fs::directory_iterator(folder, error)) {
    if (file.path().extension() == kExtension) names.insert(file.path().stem().string());
  }
  return names;
}

}  // namespace

std::optional<fs::path> shipped_model(std::string_view name) {
  return shipped_model_path(std::string(name).append(kExtension));
}

std::optional<fs::path> find_model(const std::string& name_or_file) {
  std::error_code error;
  if (fs::is_regular_file(name_or_file, error)) return name_or_file;
  return shipped_model(name_or_file);
}

std::string resolve_model(const std::string& word) {
  if (word.empty()) {
    const auto shipped = shipped_model(kDefaultModel);
    return shipped ? shipped->string() : "dsp";
  }
  if (word == "input" || word == "dsp") return word;
  const auto found = find_model(word);
  return found ? found->string() : word;
}

std::vector<std::string> shipped_model_names(std::initializer_list<std::string_view> families) {
  std::vector<std::string> names;
  for (const std::string_view family : families) {
    const auto first = shipped_model(family);
    if (!first) continue;
    for (const std::string& name : names_in(first->parent_path())) {
      if (name == family || name.starts_with(std::string(family) + "-")) names.push_back(name);
    }
  }
  std::ranges::sort(names);
  return names;
}

std::vector<std::string> shipped_model_names() {
  std::set<std::string> names;
  for (const fs::path& folder : model_folders(program_path())) names.merge(names_in(folder));
  return {names.begin(), names.end()};
}

}  // namespace earpoint
