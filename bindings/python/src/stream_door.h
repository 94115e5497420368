#pragma once

#include <memory>
#include <mutex>
#include <utility>

#include <earpoint/stream.h>

namespace earpoint::python {

/// A stream that several Python threads may call: one after the other.
class StreamDoor {
 public:
  explicit StreamDoor(Stream stream) : stream_(std::move(stream)) {}

  /// Runs work(stream); the caller does not hold Python's global lock.
  template <typename Work>
  auto alone(Work&& work) {
    const std::lock_guard guard(mutex_);
    return work(stream_);
  }

 private:
  std::mutex mutex_;
  Stream stream_;
};

}  // namespace earpoint::python
