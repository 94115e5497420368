#include <atomic>
#include <numeric>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/parallel.h>

namespace earpoint {
namespace {

TEST(ThreadPool, RunsEveryTaskOnce) {
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    for (const int tasks : {0, 1, 3, 1000}) {
      std::vector<std::atomic<int>> counts(tasks);
      pool.run(tasks, [&](std::ptrdiff_t task, int worker) {
        EXPECT_GE(worker, 0);
        EXPECT_LT(worker, threads);
        ++counts[task];
      });
      for (const auto& count : counts) EXPECT_EQ(count, 1);
    }
  }
}

TEST(ThreadPool, RethrowsTheFirstErrorAndStaysUsable) {
  ThreadPool pool(3);
  EXPECT_THROW(pool.run(100,
                        [](std::ptrdiff_t task, int) {
                          if (task == 7) throw std::runtime_error("seven");
                        }),
               std::runtime_error);
  std::atomic<int> done = 0;
  pool.run(10, [&](std::ptrdiff_t, int) { ++done; });
  EXPECT_EQ(done, 10);
}

TEST(ThreadPool, SurvivesManyShortLoops) {
  ThreadPool pool(4);
  std::atomic<std::int64_t> sum = 0;
  for (int i = 0; i < 5000; ++i) {
    pool.run(4, [&](std::ptrdiff_t task, int) { sum += task; });
  }
  EXPECT_EQ(sum, 5000 * 6);
}

TEST(AvailableCores, IsAtLeastOne) { EXPECT_GE(available_cores(), 1); }

}  // namespace
}  // namespace earpoint
