#include <earpoint/dataset/dataset_folder.h>

#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/json_field.h>
#include <earpoint/core/json_file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

fs::path record_of(const fs::path& folder) { return folder / "dataset.json"; }

/// The root below which `published` lies, if `folder` is that root, `published` itself or a folder
/// between them.
std::optional<fs::path> root_of(const fs::path& folder, const fs::path& published) {
  if (fs::is_directory(folder / published)) return folder;
  fs::path here = fs::absolute(folder).lexically_normal();
  if (!here.has_filename()) here = here.parent_path();
  fs::path walked;
  for (const fs::path& part : published) {
    walked /= part;
    fs::path root = here;
    bool ends_with = true;
    const std::vector<fs::path> parts(walked.begin(), walked.end());
    for (auto last = parts.rbegin(); last != parts.rend() && ends_with; ++last) {
      ends_with = root.filename() == *last;
      root = root.parent_path();
    }
    if (ends_with && fs::is_directory(root / published)) return root;
  }
  return std::nullopt;
}

std::optional<fs::path> soundspaces_root(const fs::path& folder) {
  return root_of(folder, SoundSpacesDataset::Options{}.folder);
}

std::optional<fs::path> replay_root(const fs::path& folder) {
  const ReplayDataset::Options options;
  const auto root = root_of(folder, options.folder);
  return root && fs::exists(*root / options.folder / options.metadata_file) ? root : std::nullopt;
}

/// Options of a data set whose dataset.json says where it lies: docs/formats.md, "Simulated data
/// sets".
SoundSpacesDataset::Options recorded_options(const fs::path& folder, const std::string& split) {
  SoundSpacesDataset::Options options{.root = folder, .split = split};
  const fs::path record = record_of(folder);
  const nlohmann::json json = read_json(record);
  const JsonField fields(json, record.string());
  options.folder = ".";
  options.speech_folder = fields.field("speech_folder").text();
  // Paths in the metadata begin with the prefix: the root is as many folders above.
  const fs::path prefix = fields.field("path_prefix").text();
  if (prefix.empty()) return options;
  const fs::path here = fs::weakly_canonical(folder);
  for (const auto& part : prefix.lexically_normal()) {
    if (!part.empty() && part != ".") options.root = options.root / "..";
  }
  if (fs::weakly_canonical(options.root / prefix) != here) {
    throw InputError(folder.string(),
                     fmt::format("its paths begin with {}, but it is elsewhere", prefix.string()),
                     "move it there");
  }
  options.folder = prefix;
  // The published place if there is one, else where the simulation wrote it.
  const fs::path published = "data/LibriSpeech-wav";
  options.speech_folder =
      fs::is_directory(options.root / published) ? published : prefix / options.speech_folder;
  return options;
}

}  // namespace

DatasetLayout layout_named(std::string_view name) {
  if (name == "soundspaces") return DatasetLayout::soundspaces;
  if (name == "replay") return DatasetLayout::replay;
  if (name == "rwavs") return DatasetLayout::rwavs;
  throw InputError("layout", fmt::format("expected soundspaces, replay or rwavs, found {}", name));
}

DatasetLayout dataset_layout(const fs::path& folder, std::optional<DatasetLayout> asked) {
  if (!fs::is_directory(folder)) throw InputError(folder.string(), "no such folder");
  const bool soundspaces = fs::exists(record_of(folder)) || soundspaces_root(folder).has_value();
  const bool replay = replay_root(folder).has_value();
  const bool rwavs = rwavs_root(folder).has_value();
  const std::string published = SoundSpacesDataset::Options{}.folder.string();
  const std::string recorded =
      (ReplayDataset::Options{}.folder / ReplayDataset::Options{}.metadata_file).string();
  const char* hint =
      "docs/datasets.md lists the folder names; `earpoint simulate` makes a data set";
  if (asked == DatasetLayout::soundspaces && !soundspaces) {
    throw InputError(folder.string(), fmt::format("holds neither a dataset.json nor {}", published),
                     hint);
  }
  if (asked == DatasetLayout::replay && !replay) {
    throw InputError(folder.string(), "holds no " + recorded, hint);
  }
  if (asked == DatasetLayout::rwavs && !rwavs) {
    throw InputError(folder.string(),
                     "holds no position.json with scenes that have transforms_scale_*.json", hint);
  }
  if (asked) return *asked;
  if (soundspaces && replay) {
    throw InputError(folder.string(), "holds SoundSpaces-NVAS and Replay-NVAS",
                     "choose the layout, soundspaces or replay");
  }
  if (rwavs && !soundspaces && !replay) return DatasetLayout::rwavs;
  if (!soundspaces && !replay) {
    throw InputError(folder.string(),
                     fmt::format("holds neither a dataset.json nor {} nor {}", published, recorded),
                     hint);
  }
  return soundspaces ? DatasetLayout::soundspaces : DatasetLayout::replay;
}

SoundSpacesDataset::Options soundspaces_options(const fs::path& folder, const std::string& split) {
  static_cast<void>(dataset_layout(folder, DatasetLayout::soundspaces));
  if (fs::exists(record_of(folder))) return recorded_options(folder, split);
  SoundSpacesDataset::Options options{.root = soundspaces_root(folder).value(), .split = split};
  // A simulated data set may lie where the published one does.
  if (fs::exists(record_of(options.root / options.folder))) {
    return recorded_options(options.root / options.folder, split);
  }
  return options;
}

ReplayDataset::Options replay_options(const fs::path& folder, const std::string& split) {
  static_cast<void>(dataset_layout(folder, DatasetLayout::replay));
  ReplayDataset::Options options;
  options.root = replay_root(folder).value();
  options.split = split;
  return options;
}

RwavsDataset::Options rwavs_options(const fs::path& folder, const std::string& split) {
  static_cast<void>(dataset_layout(folder, DatasetLayout::rwavs));
  RwavsDataset::Options options{
      .root = rwavs_root(folder).value(), .split = split, .scene = std::nullopt};
  if (!fs::exists(folder / "position.json")) {
    options.scene = fs::weakly_canonical(folder).filename().string();
  }
  return options;
}

}  // namespace earpoint
