#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <earpoint/generate/generation.h>
#include <earpoint/scene/furniture.h>
#include <earpoint/scene/import.h>

namespace earpoint {

/// Procedural homes, drawn from the seed and their index.
class HomeMaker : public SceneMaker {
 public:
  HomeMaker(std::uint64_t seed, FurnitureLibrary library)
      : seed_(seed), library_(std::move(library)) {}

  [[nodiscard]] std::shared_ptr<const PreparedScene> make(int scene) const override;
  [[nodiscard]] std::string name(int scene) const override;
  [[nodiscard]] std::string description() const override;

 private:
  std::uint64_t seed_;
  FurnitureLibrary library_;
};

/// Scans and models from files.
class FileSceneMaker : public SceneMaker {
 public:
  /// Takes what an importer warns of; called from the threads that make scenes.
  using Warn = std::function<void(const std::filesystem::path&, const std::string& warning)>;

  /// @param paths      at least one
  /// @param materials  the text of options.materials, if there is one: description() tells tables
  ///                   apart by it
  /// @param warn       once for every warning of a file, when its scene is made
  /// @throws InputError if two files have the same name
  FileSceneMaker(std::vector<std::filesystem::path> paths, ImportOptions options,
                 std::string_view materials, Warn warn);

  /// @throws InputError if the file cannot be imported
  [[nodiscard]] std::shared_ptr<const PreparedScene> make(int scene) const override;
  [[nodiscard]] std::string name(int scene) const override;
  [[nodiscard]] std::string description() const override;

 private:
  std::vector<std::filesystem::path> paths_;
  ImportOptions options_;
  std::string materials_;  // as the description calls them
  Warn warn_;
};

}  // namespace earpoint
