#include "model_search.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <exception>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

#include <earpoint/network.h>

namespace earpoint::plugin {
namespace fs = std::filesystem;

namespace {

constexpr const char* kExtension = ".safetensors";
constexpr std::array<const char*, 2> kFirst{"gtf", "enhance"};

std::vector<fs::path> folders_of(const fs::path& binary) {
  const fs::path beside = binary.parent_path();
  std::vector<fs::path> folders{beside / "models", beside.parent_path() / "Resources" / "models"};
  for (fs::path above = beside; above.has_relative_path(); above = above.parent_path()) {
    folders.push_back(above / "share" / "earpoint" / "models");
  }
  return folders;
}

void add_models_in(const fs::path& folder, std::map<std::string, fs::path>& files) {
  std::error_code error;
  for (auto file = fs::directory_iterator(folder, error);
       !error && file != fs::directory_iterator(); file.increment(error)) {
    if (file->path().extension() == kExtension) {
      files.emplace(file->path().stem().string(), file->path());
    }
  }
}

/// Nothing for what is no network. Folders near the host's program may hold anything under that
/// name, and a host must not end because of it.
std::optional<NetworkInfo> described(const std::string& model) {
  try {
    return describe_network(model);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace

std::vector<StreamingModel> find_streaming_models(const fs::path& binary) {
  std::map<std::string, fs::path> files;
  const char* named = std::getenv("EARPOINT_MODELS_DIR");
  if (named != nullptr && *named != 0) {
    add_models_in(named, files);
  } else {
    for (const fs::path& folder : folders_of(binary)) add_models_in(folder, files);
    for (const std::string& name : installed_networks()) {
      if (files.contains(name)) continue;
      if (const auto info = described(name)) files.emplace(name, info->file);
    }
  }
  std::vector<StreamingModel> models;
  for (auto& [name, file] : files) {
    const auto info = described(file.string());
    if (info && info->streams) models.push_back({name, std::move(file)});
  }
  for (auto first = kFirst.rbegin(); first != kFirst.rend(); ++first) {
    const auto found = std::ranges::find(models, *first, &StreamingModel::name);
    if (found != models.end()) std::rotate(models.begin(), found, found + 1);
  }
  if (models.size() > kMostModels) models.resize(kMostModels);
  return models;
}

}  // namespace earpoint::plugin
