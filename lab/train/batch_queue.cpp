#include "batch_queue.h"

#include <utility>

#include <earpoint/error.h>

namespace earpoint {

BatchQueue::BatchQueue(std::int64_t first, std::function<TrainingBatch(std::int64_t)> make,
                       int threads, int ahead)
    : make_(std::move(make)), ahead_(ahead), next_to_make_(first), next_to_take_(first) {
  EARPOINT_CHECK(threads > 0 && ahead > 0);
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
}

BatchQueue::~BatchQueue() {
  {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void BatchQueue::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return is_closed_ || next_to_make_ < next_to_take_ + ahead_; });
    if (is_closed_) return;
    const std::int64_t number = next_to_make_++;
    lock.unlock();
    Made made;
    try {
      made.batch = make_(number);
    } catch (...) {
      made.error = std::current_exception();
    }
    lock.lock();
    made_.emplace(number, std::move(made));
    changed_.notify_all();
  }
}

TrainingBatch BatchQueue::take() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return made_.contains(next_to_take_); });
  Made made = std::move(made_.extract(next_to_take_).mapped());
  ++next_to_take_;
  changed_.notify_all();
  lock.unlock();
  if (made.error) std::rethrow_exception(made.error);
  return std::move(made.batch);
}

}  // namespace earpoint
