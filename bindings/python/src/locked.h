#pragma once

#include <mutex>
#include <utility>

#include <pybind11/pybind11.h>

namespace earpoint::python {

/// A Renderer or a Stream that several Python threads may call: one after the other.
template <typename T>
class Locked {
 public:
  explicit Locked(T object) : object_(std::move(object)) {}

  /// Runs work(object) without Python's global lock, which the caller holds: a thread that waits
  /// for its turn does not hold up the others.
  template <typename Work>
  auto run(Work&& work) {
    const pybind11::gil_scoped_release release;
    const std::lock_guard guard(mutex_);
    return work(object_);
  }

 private:
  std::mutex mutex_;
  T object_;
};

}  // namespace earpoint::python
