#include "phase_team.h"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace earpoint::kernels {
namespace {

/// Runs `phases` phases of `tasks` tasks on a team and calls task(member, phase, i) for each.
template <typename Task>
void run_team(int threads, int phases, std::ptrdiff_t tasks, const Task& task) {
  PhaseTeam team(threads);
  team.start();
  std::vector<std::jthread> members;
  for (int member = 0; member < threads; ++member) {
    members.emplace_back([&, member] {
      for (int phase = 0; phase < phases; ++phase) {
        team.run_phase(member, tasks, [&](std::ptrdiff_t i) { task(member, phase, i); });
      }
    });
  }
}

TEST(PhaseTeam, DoesEveryTaskOnceAndInPhaseOrder) {
  constexpr int kPhases = 50;
  for (const int threads : {1, 2, 3}) {
    for (const std::ptrdiff_t tasks : {0, 1, 2, 7, 64}) {
      std::vector<std::atomic<int>> done(static_cast<std::size_t>(tasks));
      std::atomic<int> out_of_order{0};
      run_team(threads, kPhases, tasks, [&](int, int phase, std::ptrdiff_t i) {
        // A task that is done twice, left out, or begun before its phase gives another count.
        if (done[static_cast<std::size_t>(i)].fetch_add(1) != phase) ++out_of_order;
        for (const std::atomic<int>& other : done) {
          if (other.load() < phase) ++out_of_order;
        }
      });
      EXPECT_EQ(out_of_order, 0) << threads << " threads, " << tasks << " tasks";
      for (const std::atomic<int>& count : done) EXPECT_EQ(count, kPhases);
    }
  }
}

TEST(PhaseTeam, OthersTakeOverFromOneThatIsHeldUp) {
  constexpr std::ptrdiff_t kTasks = 8;
  std::vector<int> by(kTasks, -1);
  std::atomic<int> begun{0};
  std::atomic<int> done{0};
  run_team(2, 1, kTasks, [&](int member, int, std::ptrdiff_t i) {
    by[static_cast<std::size_t>(i)] = member;
    ++begun;
    // The first task ends after all others, which wait until both members are working.
    while (i == 0 ? done.load() < kTasks - 1 : begun.load() < 2) std::this_thread::yield();
    ++done;
  });
  EXPECT_EQ(by, (std::vector<int>{0, 1, 1, 1, 1, 1, 1, 1}));
}

}  // namespace
}  // namespace earpoint::kernels
