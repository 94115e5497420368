#include "lock_descriptors.h"

#include <array>
#include <atomic>
#include <mutex>

#include <pthread.h>
#include <unistd.h>

namespace earpoint {
namespace {

/// Descriptors, each one more than its number; 0 is an empty place. Where there is no place left
/// the lock may outlive its process by as long as the child runs.
std::array<std::atomic<int>, 1024> places{};

void close_all() {
  for (auto& place : places) {
    if (const int descriptor = place.exchange(0) - 1; descriptor >= 0) ::close(descriptor);
  }
}

}  // namespace

void close_in_children(int descriptor) {
  static std::once_flag once;
  std::call_once(once, [] { ::pthread_atfork(nullptr, nullptr, close_all); });
  for (auto& place : places) {
    int empty = 0;
    if (place.compare_exchange_strong(empty, descriptor + 1)) return;
  }
}

void close_lock(int descriptor) {
  for (auto& place : places) {
    int found = descriptor + 1;
    if (place.compare_exchange_strong(found, 0)) break;
  }
  ::close(descriptor);
}

}  // namespace earpoint
