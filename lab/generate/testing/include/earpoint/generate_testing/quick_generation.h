#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include <earpoint/generate/generation.h>
#include <earpoint/scene/scene_builder.h>

namespace earpoint {

/// A folder of its own for the running test, empty; removed with the object.
class TestFolder {
 public:
  explicit TestFolder(const std::string& name);
  ~TestFolder();
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Writes a corpus of three voices of either gender, two recordings of 1.2 s each: pulses of noise
/// like syllables, their own for every voice.
/// @return the folder
std::filesystem::path write_test_corpus(const std::filesystem::path& folder);

/// A small data set that is made in seconds: few rays, short responses, small pictures.
GenerationOptions quick_options(const std::filesystem::path& folder);

/// A living room of 6 x 5 x 2.6 m and a room beside it, with a wall and an open doorway between.
Scene two_rooms();

/// Two rooms at any index.
class TestScenes : public SceneMaker {
 public:
  [[nodiscard]] std::shared_ptr<const PreparedScene> make(int scene) const override;
  [[nodiscard]] std::string name(int scene) const override;
  [[nodiscard]] std::string description() const override { return "two rooms"; }
};

/// Every file below a folder, by its path there.
std::map<std::string, std::string> contents_of(const std::filesystem::path& folder);

}  // namespace earpoint
