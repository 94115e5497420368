#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/core/progress.h>
#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/evaluate/method.h>
#include <earpoint/study/make_study.h>

namespace earpoint {

/// A folder of one test's own, gone afterwards.
class TestFolder {
 public:
  TestFolder() {
    static int count = 0;
    path_ =
        std::filesystem::path(testing::TempDir()) / fmt::format("study-{}-{}", ::getpid(), ++count);
    std::filesystem::create_directories(path_);
  }
  ~TestFolder() { std::filesystem::remove_all(path_); }
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// What the source heard with its ears exchanged.
class ExchangedMethod : public Method {
 public:
  Waveform render(const Question& question) override {
    Waveform sound = question.sample.source;
    std::ranges::copy(question.sample.source.channel(0), sound.channel(1).begin());
    std::ranges::copy(question.sample.source.channel(1), sound.channel(0).begin());
    return sound;
  }
};

/// The left ear alone, twice as loud.
class LeftMethod : public Method {
 public:
  Waveform render(const Question& question) override {
    Waveform sound = question.sample.source;
    for (std::ptrdiff_t i = 0; i < sound.samples(); ++i) {
      sound.channel(0)[i] *= 2.0F;
      sound.channel(1)[i] = 0.0F;
    }
    return sound;
  }
};

inline std::vector<MethodEntry> test_methods() {
  return {
      input_method(),
      {.name = "exchanged",
       .what = "for tests",
       .make = [] { return std::make_unique<ExchangedMethod>(); }},
      {.name = "left", .what = "for tests", .make = [] { return std::make_unique<LeftMethod>(); }}};
}

inline StudyRequest test_request(StudyDesign design) {
  return {.design = design,
          .title = "A study",
          .data = "tiny",
          .split = "test",
          .count = 6,
          .controls = 2,
          .seed = 3,
          .duration_s = 1.0,
          .baselines = {"input"}};
}

/// Makes the study of a request in `folder`/study, out of a tiny data set beside it.
inline Study make_test_study(const std::filesystem::path& folder, const StudyRequest& request) {
  const std::filesystem::path data = folder / "data";
  if (!std::filesystem::exists(data)) write_tiny_dataset(data, {.clips = 8});
  const auto material =
      study_material(data, DatasetLayout::soundspaces, request.split, {}, request.duration_s);
  SilentProgress progress;
  return make_study(*material, test_methods(), request, folder / "study", progress);
}

/// Puts the study of test_request() in `folder`/study; it is made once for all tests.
inline Study copy_test_study(const std::filesystem::path& folder, StudyDesign design) {
  static std::array<std::unique_ptr<TestFolder>, 2> made;
  auto& place = made.at(static_cast<std::size_t>(design));
  if (!place) {
    place = std::make_unique<TestFolder>();
    make_test_study(place->path(), test_request(design));
  }
  std::filesystem::copy(place->path() / "study", folder / "study",
                        std::filesystem::copy_options::recursive);
  return read_study(folder / "study");
}

}  // namespace earpoint
