#pragma once

#include <atomic>
#include <cstddef>
#include <thread>

namespace earpoint::infer {

/// Work in phases for a team of threads: a phase starts when every task of the one before is done.
/// Each thread of the team walks through all phases and, in each, takes tasks while there are any.
/// Threads wait spinning, as phases are much shorter than a sleep; after a while they yield.
class PhaseTeam {
 public:
  explicit PhaseTeam(int threads) : threads_(threads) {}

  /// Before the team starts; by one thread.
  void start() {
    next_.store(0, std::memory_order_relaxed);
    arrived_.store(0, std::memory_order_relaxed);
    phase_.store(0, std::memory_order_relaxed);
  }

  /// Calls task(i) for some of 0 <= i < tasks and returns when the whole team has done all of them.
  /// Every thread of the team must call it with the same count, phase by phase.
  template <typename Task>
  void run_phase(std::ptrdiff_t tasks, const Task& task) {
    while (true) {
      const std::ptrdiff_t i = next_.fetch_add(1, std::memory_order_relaxed);
      if (i >= tasks) break;
      task(i);
    }
    wait_for_team();
  }

 private:
  void wait_for_team() {
    const std::size_t phase = phase_.load(std::memory_order_relaxed);
    if (arrived_.fetch_add(1, std::memory_order_acq_rel) + 1 == threads_) {
      arrived_.store(0, std::memory_order_relaxed);
      next_.store(0, std::memory_order_relaxed);
      phase_.store(phase + 1, std::memory_order_release);
      return;
    }
    for (int spins = 0; phase_.load(std::memory_order_acquire) == phase; ++spins) {
      if (spins > kSpinsBeforeYield) std::this_thread::yield();
    }
  }

  static constexpr int kSpinsBeforeYield = 4096;

  int threads_;
  alignas(64) std::atomic<std::ptrdiff_t> next_{0};
  alignas(64) std::atomic<int> arrived_{0};
  alignas(64) std::atomic<std::size_t> phase_{0};
};

}  // namespace earpoint::infer
