#pragma once

#include <atomic>
#include <cstdlib>
#include <new>

/// Number of calls of operator new so far, also by the library: this one replaces the standard one.
/// To be included by one source file only.
inline std::atomic<long> allocation_count{0};
inline long allocations() { return allocation_count; }

void* operator new(std::size_t size) {
  ++allocation_count;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
