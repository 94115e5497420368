#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

namespace earpoint::kernels {

/// Work in phases for a team of threads: a phase starts when every task of the one before is done.
/// Each thread of the team walks through all phases. In each it takes the tasks of its share in
/// turn, the same share in every phase of as many tasks, so that it finds in its caches what it
/// wrote there; then it takes from the far end of the others' shares. Threads wait spinning, as
/// phases are much shorter than a sleep; after a while they yield.
class PhaseTeam {
 public:
  explicit PhaseTeam(int threads) : shares_(static_cast<std::size_t>(threads)) {}

  /// Before the team starts; by one thread.
  void start() {
    for (Share& share : shares_) share.taken.store(0, std::memory_order_relaxed);
    arrived_.store(0, std::memory_order_relaxed);
    phase_.store(0, std::memory_order_relaxed);
  }

  /// Calls task(i) for some of 0 <= i < tasks and returns when the whole team has done all of them.
  /// Every thread of the team must call it with the same count, phase by phase.
  /// @param member  which thread of the team calls
  /// @param tasks   < 2^32
  template <typename Task>
  void run_phase(int member, std::ptrdiff_t tasks, const Task& task) {
    const auto threads = std::ssize(shares_);
    for (std::ptrdiff_t i = 0; i < threads; ++i) {
      const std::ptrdiff_t owner = (member + i) % threads;
      const std::ptrdiff_t first = owner * tasks / threads;
      const std::ptrdiff_t end = (owner + 1) * tasks / threads;
      Share& share = shares_[static_cast<std::size_t>(owner)];
      while (const auto taken = i == 0 ? share.take(end - first, kFromFront)
                                       : share.take(end - first, kFromBack)) {
        task(i == 0 ? first + *taken : end - 1 - *taken);
      }
    }
    wait_for_team();
  }

 private:
  // How many tasks of a share have been taken: from its front in the lower half of the number, from
  // its back in the upper half.
  static constexpr int kHalf = 32;
  static constexpr std::uint64_t kFromFront = 1;
  static constexpr std::uint64_t kFromBack = std::uint64_t{1} << kHalf;

  struct alignas(64) Share {
    /// @return how many were taken from that side before; nothing if the share is used up
    std::optional<std::ptrdiff_t> take(std::ptrdiff_t tasks, std::uint64_t side) {
      std::uint64_t before = taken.load(std::memory_order_relaxed);
      while (true) {
        const std::uint64_t from_front = before % kFromBack;
        const std::uint64_t from_back = before >> kHalf;
        if (from_front + from_back >= static_cast<std::uint64_t>(tasks)) return std::nullopt;
        if (taken.compare_exchange_weak(before, before + side, std::memory_order_relaxed)) {
          return static_cast<std::ptrdiff_t>(side == kFromFront ? from_front : from_back);
        }
      }
    }

    std::atomic<std::uint64_t> taken{0};
  };

  void wait_for_team() {
    const std::size_t phase = phase_.load(std::memory_order_relaxed);
    if (arrived_.fetch_add(1, std::memory_order_acq_rel) + 1 == std::ssize(shares_)) {
      arrived_.store(0, std::memory_order_relaxed);
      for (Share& share : shares_) share.taken.store(0, std::memory_order_relaxed);
      phase_.store(phase + 1, std::memory_order_release);
      return;
    }
    for (int spins = 0; phase_.load(std::memory_order_acquire) == phase; ++spins) {
      if (spins > kSpinsBeforeYield) std::this_thread::yield();
    }
  }

  static constexpr int kSpinsBeforeYield = 4096;

  std::vector<Share> shares_;
  alignas(64) std::atomic<int> arrived_{0};
  alignas(64) std::atomic<std::size_t> phase_{0};
};

}  // namespace earpoint::kernels
