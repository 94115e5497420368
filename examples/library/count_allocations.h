#pragma once

#include <atomic>
#include <cstdlib>
#include <new>

/// How often operator new was called so far, by the library too: this program's own takes the place
/// of the standard one. Included by one source file.
inline std::atomic<long> allocation_count{0};
inline long allocations() { return allocation_count; }

void* operator new(std::size_t size) {
  ++allocation_count;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
