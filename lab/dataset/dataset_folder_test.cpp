#include <filesystem>
#include <functional>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/core/file.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class DatasetFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) / ("dataset_folder." + std::to_string(::getpid()));
    fs::remove_all(root_);
    fs::create_directories(root_);
  }
  void TearDown() override { fs::remove_all(root_); }

  void add_soundspaces() const {
    fs::create_directories(root_ / "data/synthetic_dataset/v16/test");
  }
  void add_replay() const {
    fs::create_directories(root_ / "data/appen_dataset/v3");
    write_file(root_ / "data/appen_dataset/v3/metadata_v2.json", std::string_view("{}"));
  }

  static std::string error_of(const std::function<void()>& act) {
    try {
      act();
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  fs::path root_;
};

TEST_F(DatasetFolder, IsFoundFromItsRootAndFromEveryFolderOnTheWay) {
  add_soundspaces();
  for (const char* folder : {"", "data", "data/synthetic_dataset", "data/synthetic_dataset/v16",
                             "data/synthetic_dataset/v16/"}) {
    EXPECT_EQ(dataset_layout(root_ / folder, {}), DatasetLayout::soundspaces) << folder;
    const auto options = soundspaces_options(root_ / folder, "test");
    EXPECT_TRUE(fs::equivalent(options.root, root_)) << folder;
    EXPECT_EQ(options.folder, "data/synthetic_dataset/v16");
  }
  EXPECT_NE(error_of([&] {
              static_cast<void>(dataset_layout(root_ / "data/synthetic_dataset/v16/test", {}));
            }).find("holds neither"),
            std::string::npos);
}

TEST_F(DatasetFolder, ReplayIsFoundInTheSameWay) {
  add_replay();
  for (const char* folder : {"", "data", "data/appen_dataset/v3"}) {
    EXPECT_EQ(dataset_layout(root_ / folder, {}), DatasetLayout::replay) << folder;
    EXPECT_TRUE(fs::equivalent(replay_options(root_ / folder, "test").root, root_)) << folder;
  }
}

TEST_F(DatasetFolder, BothUnderOneRootMustBeToldApart) {
  add_soundspaces();
  add_replay();
  EXPECT_NE(error_of([&] {
              static_cast<void>(dataset_layout(root_, {}));
            }).find("choose the layout, soundspaces or replay"),
            std::string::npos);
  EXPECT_EQ(dataset_layout(root_, DatasetLayout::replay), DatasetLayout::replay);
  EXPECT_EQ(dataset_layout(root_, DatasetLayout::soundspaces), DatasetLayout::soundspaces);
  // A folder that belongs to one of them selects that layout.
  EXPECT_EQ(dataset_layout(root_ / "data/synthetic_dataset/v16", {}), DatasetLayout::soundspaces);
  EXPECT_EQ(dataset_layout(root_ / "data/appen_dataset/v3", {}), DatasetLayout::replay);
}

TEST_F(DatasetFolder, SaysWhatIsNotThere) {
  const auto of = [&](const fs::path& folder, std::optional<DatasetLayout> asked) {
    return error_of([&] { static_cast<void>(dataset_layout(folder, asked)); });
  };
  EXPECT_NE(of(root_ / "none", {}).find("no such folder"), std::string::npos);
  EXPECT_NE(of(root_, {}).find("holds neither a dataset.json"), std::string::npos);
  add_soundspaces();
  EXPECT_NE(of(root_, DatasetLayout::replay).find("holds no data/appen_dataset/v3/metadata_v2"),
            std::string::npos);
  EXPECT_NE(error_of([] { static_cast<void>(layout_named("v16")); }).find("expected soundspaces"),
            std::string::npos);
}

}  // namespace
}  // namespace earpoint
