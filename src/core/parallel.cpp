#include <earpoint/core/parallel.h>

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include <earpoint/core/platform/usable_processors.h>
#include <earpoint/error.h>

namespace earpoint {

struct ThreadPool::State {
  using Body = FunctionRef<void(std::ptrdiff_t, int)>;

  std::mutex mutex;
  std::condition_variable wake;
  std::condition_variable idle;
  std::uint64_t generation = 0;  // one per loop; guarded by mutex
  int busy = 0;                  // workers still inside the loop; guarded by mutex
  bool stopping = false;         // guarded by mutex

  std::optional<Body> body;
  std::ptrdiff_t tasks = 0;
  std::atomic<std::ptrdiff_t> next{0};
  std::exception_ptr error;  // guarded by mutex

  std::vector<std::thread> threads;

  void work(int worker) {
    while (true) {
      const std::ptrdiff_t task = next.fetch_add(1, std::memory_order_relaxed);
      if (task >= tasks) return;
      try {
        (*body)(task, worker);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!error) error = std::current_exception();
        next.store(tasks, std::memory_order_relaxed);
      }
    }
  }

  void serve(int worker) {
    std::uint64_t seen = 0;
    while (true) {
      {
        std::unique_lock lock(mutex);
        wake.wait(lock, [&] { return stopping || generation != seen; });
        if (stopping) return;
        seen = generation;
      }
      work(worker);
      const std::lock_guard lock(mutex);
      if (--busy == 0) idle.notify_one();
    }
  }
};

ThreadPool::ThreadPool(int threads) : state_(std::make_unique<State>()) {
  EARPOINT_CHECK(threads > 0);
  for (int worker = 1; worker < threads; ++worker) {
    state_->threads.emplace_back([state = state_.get(), worker] { state->serve(worker); });
  }
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stopping = true;
  }
  state_->wake.notify_all();
  for (std::thread& thread : state_->threads) thread.join();
}

int ThreadPool::threads() const { return static_cast<int>(state_->threads.size()) + 1; }

void ThreadPool::run(std::ptrdiff_t tasks, FunctionRef<void(std::ptrdiff_t, int)> body) {
  State& state = *state_;
  {
    const std::lock_guard lock(state.mutex);
    state.body.emplace(body);
    state.tasks = tasks;
    state.next.store(0, std::memory_order_relaxed);
    state.error = nullptr;
    state.busy = static_cast<int>(state.threads.size());
    ++state.generation;
  }
  state.wake.notify_all();
  state.work(0);

  std::unique_lock lock(state.mutex);
  state.idle.wait(lock, [&] { return state.busy == 0; });
  if (state.error) std::rethrow_exception(std::exchange(state.error, nullptr));
}

int available_cores() { return usable_processors(); }

}  // namespace earpoint
