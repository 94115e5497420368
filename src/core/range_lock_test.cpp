#include <array>
#include <csignal>
#include <filesystem>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <earpoint/core/range_lock.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class RangeLockTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::remove(file_); }
  void TearDown() override { fs::remove(file_); }
  fs::path file_ = fs::path(testing::TempDir()) / ("range_lock_test_" + std::to_string(::getpid()));
};

TEST_F(RangeLockTest, PartsThatOverlapExcludeEachOtherAndOthersDoNot) {
  RangeLock one(file_);
  RangeLock two(file_);
  EXPECT_TRUE(one.try_lock(10, 5));
  EXPECT_FALSE(two.try_lock(14, 2));
  EXPECT_TRUE(two.try_lock(15, 2));
  EXPECT_TRUE(two.others_hold_from(14));
  EXPECT_FALSE(two.others_hold_from(15));  // its own do not count
  one.unlock(10, 5);
  EXPECT_TRUE(two.try_lock(14, 1));
}

TEST_F(RangeLockTest, AKilledProcessHoldsNothing) {
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    RangeLock lock(file_);
    const char locked = lock.try_lock(1, 1) ? 1 : 0;
    (void)!::write(pipe[1], &locked, 1);
    while (true) ::pause();
  }
  char locked = 0;
  ASSERT_EQ(::read(pipe[0], &locked, 1), 1);
  EXPECT_EQ(locked, 1);
  RangeLock mine(file_);
  EXPECT_FALSE(mine.try_lock(1, 1));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_TRUE(mine.try_lock(1, 1));
  for (const int end : pipe) ::close(end);
}

TEST_F(RangeLockTest, AChildThatLivesOnHoldsNothing) {
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  pid_t child = 0;
  {
    RangeLock lock(file_);
    ASSERT_TRUE(lock.try_lock(1, 1));
    child = ::fork();
    if (child == 0) {
      char end = 0;
      (void)!::read(pipe[0], &end, 1);
      ::_exit(0);
    }
  }
  RangeLock mine(file_);
  // The child closes what it inherited when it first runs.
  bool is_free = false;
  for (int i = 0; i < 1000 && !is_free; ++i, ::usleep(1000)) is_free = mine.try_lock(1, 1);
  EXPECT_TRUE(is_free);
  (void)!::write(pipe[1], "x", 1);
  ::waitpid(child, nullptr, 0);
  for (const int end : pipe) ::close(end);
}

}  // namespace
}  // namespace earpoint
