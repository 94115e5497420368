#include <earpoint/generate/scene_maker.h>

#include <algorithm>

#include <fmt/format.h>

#include <earpoint/core/name_number.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/scene/homes.h>

namespace earpoint {

std::shared_ptr<const PreparedScene> HomeMaker::make(int scene) const {
  const std::uint64_t seed = RandomStream(seed_, {static_cast<std::uint64_t>(scene)}).next();
  return prepare_home(name(scene), make_home(seed, {}, library_).scene);
}

std::string HomeMaker::name(int scene) const { return fmt::format("home-{:04}", scene); }

std::string HomeMaker::description() const {
  return fmt::format("homes with {} models of furniture", library_.models().size());
}

FileSceneMaker::FileSceneMaker(std::vector<std::filesystem::path> paths, ImportOptions options,
                               std::string_view materials, Warn warn)
    : paths_(std::move(paths)),
      options_(options),
      materials_(options.materials == nullptr ? "standard"
                                              : fmt::format("{:016x}", name_number(materials))),
      warn_(std::move(warn)) {
  EARPOINT_CHECK(!paths_.empty());
  EARPOINT_CHECK(warn_ != nullptr);
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (paths_[i].stem() != paths_[j].stem()) continue;
      throw InputError(paths_[i].string(), "another scene is called " + paths_[j].stem().string(),
                       "rename one of them");
    }
  }
}

std::shared_ptr<const PreparedScene> FileSceneMaker::make(int scene) const {
  const std::filesystem::path& path = paths_.at(scene);
  ImportedScene imported = import_scene(path, options_);
  for (const std::string& warning : imported.report.warnings()) warn_(path, warning);
  return prepare_scan(name(scene), std::move(imported.scene));
}

std::string FileSceneMaker::name(int scene) const { return paths_.at(scene).stem().string(); }

std::string FileSceneMaker::description() const {
  std::string text = "files";
  for (const auto& path : paths_) text += " " + path.filename().string();
  if (options_.up_axis) text += *options_.up_axis == UpAxis::y ? ", up y" : ", up z";
  if (options_.close_ceiling) text += ", ceiling closed";
  return text + fmt::format(", unit {:g} m, materials {}", options_.unit_m, materials_);
}

}  // namespace earpoint
