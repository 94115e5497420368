#pragma once

#include <cstddef>

namespace earpoint {

/// The size of the pages that prefer_large_pages() asks for.
constexpr std::size_t kLargePage_bytes = std::size_t{2} << 20;

/// Asks for large pages, which cost fewer misses of the address cache. A wish: where it is not
/// granted, only speed is lost.
/// @param memory  not touched yet, aligned to kLargePage_bytes
/// @param bytes   a multiple of kLargePage_bytes
void prefer_large_pages(void* memory, std::size_t bytes);

/// Tells the C library to keep freed memory: activations of a training step are as large as those
/// of the next, and handing the pages back and forth takes up to half of the time. Affects the
/// whole process.
void keep_freed_memory();

}  // namespace earpoint
