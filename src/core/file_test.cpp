#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/core/error.h>
#include <earpoint/core/file.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class FileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::path(testing::TempDir()) /
        ("file_test_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] int entries() const {
    return static_cast<int>(std::distance(fs::directory_iterator(folder_), {}));
  }

  fs::path folder_;
};

TEST_F(FileTest, WhatIsWrittenIsRead) {
  const std::string text("a\0b\nc", 5);
  write_file(folder_ / "x.txt", text);
  EXPECT_EQ(read_text_file(folder_ / "x.txt"), text);
  EXPECT_EQ(read_file(folder_ / "x.txt").size(), text.size());
  EXPECT_EQ(entries(), 1);
}

TEST_F(FileTest, WithoutCommitNothingIsLeftAndTheOldFileStays) {
  write_file(folder_ / "x.txt", "old");
  {
    const AtomicFile file(folder_ / "x.txt");
    EXPECT_EQ(file.temporary_path().extension(), ".txt");
    EXPECT_EQ(entries(), 2);
  }
  EXPECT_EQ(entries(), 1);
  EXPECT_EQ(read_text_file(folder_ / "x.txt"), "old");
}

TEST_F(FileTest, BadPathsAreNamed) {
  EXPECT_THROW((void)read_file(folder_ / "missing"), InputError);
  EXPECT_THROW((void)read_file(folder_), InputError);
  EXPECT_THROW(write_file(folder_ / "no" / "x.txt", "text"), InputError);
  EXPECT_THROW(write_file(folder_, "text"), InputError);
}

TEST(InputErrorTest, IsOneLineWithPlaceProblemAndMend) {
  const InputError error("clip.mp4", "has no\nsound", "record again");
  EXPECT_STREQ(error.what(), "clip.mp4: has no sound; record again");
}

TEST(Check, ThrowsWithTheConditionInItsMessage) {
  try {
    EARPOINT_CHECK(1 + 1 == 3);
    FAIL() << "expected logic_error";
  } catch (const std::logic_error& error) {
    EXPECT_NE(std::string(error.what()).find("1 + 1 == 3"), std::string::npos);
  }
}

TEST(Check, DcheckFiresInTheBuildThatTestsRun) {
#if defined(EARPOINT_DCHECK_ENABLED)
  EXPECT_THROW(EARPOINT_DCHECK(false), std::logic_error);
#else
  EARPOINT_DCHECK(false);
#endif
}

}  // namespace
}  // namespace earpoint
