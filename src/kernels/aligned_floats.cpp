#include <earpoint/kernels/aligned_floats.h>

#include <cstdlib>
#include <cstring>
#include <new>

#include <earpoint/core/platform/memory.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr std::size_t kAlignment = 64;

}  // namespace

AlignedFloats::AlignedFloats(std::ptrdiff_t size) : size_(size) {
  EARPOINT_CHECK(size >= 0);
  if (size == 0) return;
  const std::size_t needed = static_cast<std::size_t>(size) * sizeof(float);
  const std::size_t alignment = needed < kLargePage_bytes ? kAlignment : kLargePage_bytes;
  const std::size_t bytes = (needed + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, bytes);
  if (memory == nullptr) throw std::bad_alloc();
  if (alignment == kLargePage_bytes) prefer_large_pages(memory, bytes);
  std::memset(memory, 0, bytes);
  data_.reset(static_cast<float*>(memory));
}

void AlignedFloats::Free::operator()(float* data) const { std::free(data); }

}  // namespace earpoint
