#include "model_search.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <system_error>
#include <utility>

#include <earpoint/error.h>
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
  for (const fs::directory_entry& file : fs::directory_iterator(folder, error)) {
    if (file.path().extension() == kExtension) {
      files.emplace(file.path().stem().string(), file.path());
    }
  }
}

bool streams(const std::string& model) {
  try {
    return describe_network(model).streams;
  } catch (const InputError&) {
    return false;
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
      if (!files.contains(name)) files.emplace(name, describe_network(name).file);
    }
  }
  std::vector<StreamingModel> models;
  for (auto& [name, file] : files) {
    if (streams(file.string())) models.push_back({name, std::move(file)});
  }
  for (auto first = kFirst.rbegin(); first != kFirst.rend(); ++first) {
    const auto found = std::ranges::find(models, *first, &StreamingModel::name);
    if (found != models.end()) std::rotate(models.begin(), found, found + 1);
  }
  if (models.size() > kMostModels) models.resize(kMostModels);
  return models;
}

}  // namespace earpoint::plugin
