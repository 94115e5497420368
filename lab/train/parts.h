#pragma once

#include <cstddef>
#include <functional>

#include <earpoint/core/parallel.h>

namespace earpoint {

/// While it lives, LibTorch computes with this thread alone when this thread asks it to.
class OneThread {
 public:
  OneThread();
  ~OneThread();
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int threads_before_;
};

/// Threads that work on parts of a batch, each part by one thread from end to end. LibTorch's own
/// threads split every operation instead, and wait for each other after each.
class PartTeam {
 public:
  /// With as many threads as LibTorch has; see set_learner_threads().
  PartTeam();

  /// Calls work(part) for every part and returns when all are done. Parts must not depend on who
  /// does them: then neither do the numbers.
  void run(std::ptrdiff_t parts, const std::function<void(std::ptrdiff_t)>& work);

 private:
  ThreadPool pool_;
};

}  // namespace earpoint
