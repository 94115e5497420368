#include <earpoint/core/platform/memory.h>

#include <limits>

#include <malloc.h>
#include <sys/mman.h>

namespace earpoint {

void prefer_large_pages(void* memory, std::size_t bytes) {
  static_cast<void>(madvise(memory, bytes, MADV_HUGEPAGE));
}

void keep_freed_memory() {
  // Without mmap, all memory comes from one heap, whose top is never given back. Arenas of other
  // threads would be mapped, so all threads share this one.
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_ARENA_MAX, 1);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  mallopt(M_TOP_PAD, 64 << 20);
}

}  // namespace earpoint
