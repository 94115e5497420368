#include <earpoint/core/temporary_folder.h>

#include <filesystem>
#include <string_view>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>

namespace earpoint {
namespace {

TEST(TemporaryFolder, IsThereForItselfAloneAndGoesWithWhatItHolds) {
  std::filesystem::path path;
  {
    const TemporaryFolder folder;
    const TemporaryFolder other;
    path = folder.path();
    EXPECT_NE(path, other.path());
    write_file(path / "inside.txt", std::string_view("text"));
    EXPECT_TRUE(std::filesystem::exists(path / "inside.txt"));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace earpoint
