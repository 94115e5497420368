#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>

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

/// A process that is ended by the signal while it writes its temporary file; @return its status
int end_while_writing(const fs::path& path, int signal) {
  std::array<int, 2> pipe{};
  EXPECT_EQ(::pipe(pipe.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    remove_partial_files_on_signals();
    const AtomicFile file(path);
    (void)!::write(pipe[1], "x", 1);
    while (true) ::pause();
  }
  char ready = 0;
  EXPECT_EQ(::read(pipe[0], &ready, 1), 1);
  ::kill(child, signal);
  int status = 0;
  ::waitpid(child, &status, 0);
  for (const int end : pipe) ::close(end);
  return status;
}

TEST_F(FileTest, SignalsRemoveWhatWasWrittenAsideAndEndTheProcessAsEver) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
    const int status = end_while_writing(folder_ / "x.txt", signal);
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == signal) << signal;
    EXPECT_EQ(entries(), 0) << signal;
  }
}

TEST_F(FileTest, WhatAKilledProcessLeftTheNextWriterTakes) {
  end_while_writing(folder_ / "x.txt", SIGKILL);
  EXPECT_EQ(entries(), 1);
  // As if two writers had been killed at the same time.
  fs::copy(folder_ / ".x.partial.txt", folder_ / ".x.1.partial.txt");
  write_file(folder_ / "x.txt", "text");
  EXPECT_EQ(entries(), 1);
  EXPECT_EQ(read_text_file(folder_ / "x.txt"), "text");
}

TEST_F(FileTest, TwoWritersOfOneFileDoNotMix) {
  const AtomicFile one(folder_ / "x.txt");
  AtomicFile two(folder_ / "x.txt");
  EXPECT_NE(one.temporary_path(), two.temporary_path());
  std::ofstream(two.temporary_path()) << "two";
  std::ofstream(one.temporary_path()) << "one";
  two.commit();
  EXPECT_EQ(read_text_file(folder_ / "x.txt"), "two");
}

TEST_F(FileTest, ASymbolicLinkIsWrittenThrough) {
  fs::create_directory(folder_ / "there");
  fs::create_symlink("there/x.txt", folder_ / "link.txt");
  write_file(folder_ / "link.txt", "text");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.txt"));
  EXPECT_EQ(read_text_file(folder_ / "there/x.txt"), "text");
  fs::create_symlink("nothing.txt", folder_ / "dangling.txt");
  EXPECT_EQ(written_place(folder_ / "dangling.txt"), written_place(folder_ / "./nothing.txt"));
  EXPECT_NE(written_place(folder_ / "dangling.txt"), written_place(folder_ / "link.txt"));
}

TEST_F(FileTest, APipeGetsTheBytesAndADeviceStays) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::string got;
  std::thread reader([&] {
    std::ifstream stream(pipe);
    std::getline(stream, got);
  });
  write_file(pipe, "text\n");
  reader.join();
  EXPECT_EQ(got, "text");
  EXPECT_TRUE(fs::is_fifo(pipe));
  EXPECT_THROW(write_file("/dev/full", "text"), InputError);
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_F(FileTest, APipeIsStoredToBeReadTwice) {
  EXPECT_EQ(stored_input("x.txt"), "x.txt");
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(pipe) << "text"; });
  const fs::path stored = stored_input(pipe);
  writer.join();
  EXPECT_EQ(read_text_file(stored), "text");
  EXPECT_EQ(read_text_file(stored), "text");
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
