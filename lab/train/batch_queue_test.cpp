#include "batch_queue.h"

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

namespace earpoint {
namespace {

TrainingBatch numbered(std::int64_t number) {
  TrainingBatch batch;
  batch.clips = number;
  return batch;
}

TEST(BatchQueue, GivesBatchesInOrderWhoeverIsFirst) {
  BatchQueue queue(
      5,
      [](std::int64_t number) {
        // Every third batch takes longer than the ones after it.
        if (number % 3 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(3));
        return numbered(number);
      },
      4, 6);
  for (std::int64_t number = 5; number < 40; ++number) EXPECT_EQ(queue.take().clips, number);
}

TEST(BatchQueue, MakesNoMoreThanItMayKeep) {
  std::atomic<std::int64_t> made = 0;
  BatchQueue queue(
      0,
      [&](std::int64_t number) {
        ++made;
        return numbered(number);
      },
      3, 4);
  queue.take();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_LE(made.load(), 5);
}

TEST(BatchQueue, ThrowsWhatWasThrownInItsPlace) {
  BatchQueue queue(
      0,
      [](std::int64_t number) {
        if (number == 2) throw std::runtime_error("two");
        return numbered(number);
      },
      2, 4);
  EXPECT_EQ(queue.take().clips, 0);
  EXPECT_EQ(queue.take().clips, 1);
  EXPECT_THROW(queue.take(), std::runtime_error);
}

}  // namespace
}  // namespace earpoint
