#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/network/shipped_model.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class ShippedModel : public ::testing::Test {
 protected:
  void SetUp() override {
    ::unsetenv("EARPOINT_MODELS_DIR");
    folder_ = fs::path(EARPOINT_BINARY_DIR) / "shipped_model_test" /
              ::testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
  }
  void TearDown() override {
    ::unsetenv("EARPOINT_MODELS_DIR");
    fs::remove_all(folder_);
  }

  /// Makes an empty file below the folder.
  fs::path make(const fs::path& below) {
    fs::create_directories((folder_ / below).parent_path());
    write_file(folder_ / below, "");
    return folder_ / below;
  }

  fs::path folder_;
};

TEST_F(ShippedModel, IsFoundUnderTheProgramsPrefix) {
  const fs::path model = make("share/earpoint/models/a.safetensors");
  EXPECT_EQ(shipped_model_path("a.safetensors", folder_ / "bin/earpoint"), model);
}

TEST_F(ShippedModel, IsFoundInTheSourceTreeThatHoldsTheBuild) {
  const fs::path model = make("models/a.safetensors");
  EXPECT_EQ(shipped_model_path("a.safetensors", folder_ / "build/dev/apps/earpoint/earpoint"),
            model);
}

TEST_F(ShippedModel, OfAnotherNameIsNotFound) {
  make("models/a.safetensors");
  EXPECT_EQ(shipped_model_path("b.safetensors", folder_ / "bin/earpoint"), std::nullopt);
}

TEST_F(ShippedModel, ComesFromTheNamedFolderOnly) {
  make("models/a.safetensors");
  const fs::path mine = make("mine/b.safetensors");
  ::setenv("EARPOINT_MODELS_DIR", (folder_ / "mine").c_str(), 1);
  EXPECT_EQ(shipped_model_path("b.safetensors", folder_ / "bin/earpoint"), mine);
  EXPECT_EQ(shipped_model_path("a.safetensors", folder_ / "bin/earpoint"), std::nullopt);
}

}  // namespace
}  // namespace earpoint
