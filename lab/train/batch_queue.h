#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include <earpoint/train/training_batch.h>

namespace earpoint {

/// Makes batches on its own threads, a few ahead of the consumer, in ascending order.
class BatchQueue {
 public:
  /// @param first   number of the first batch that will be taken
  /// @param make    makes a batch of its number; many threads call it
  /// @param ahead   how many batches may wait, > 0
  BatchQueue(std::int64_t first, std::function<TrainingBatch(std::int64_t)> make, int threads,
             int ahead);
  ~BatchQueue();
  BatchQueue(const BatchQueue&) = delete;
  BatchQueue& operator=(const BatchQueue&) = delete;

  /// The next batch; waits for it. What `make` threw for it is thrown here.
  TrainingBatch take();

 private:
  struct Made {
    TrainingBatch batch;
    std::exception_ptr error;
  };
  void work();

  std::function<TrainingBatch(std::int64_t)> make_;
  int ahead_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::int64_t, Made> made_;
  std::int64_t next_to_make_;
  std::int64_t next_to_take_;
  bool is_closed_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace earpoint
