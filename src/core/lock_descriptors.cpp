#include "lock_descriptors.h"

#include <array>
#include <atomic>
#include <mutex>

#include <pthread.h>
#include <unistd.h>

namespace earpoint {
namespace {

/// Descriptors, stored as their number + 1; 0 is an empty place. If no place is left, a lock may
/// outlive its process for as long as a child runs.
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
