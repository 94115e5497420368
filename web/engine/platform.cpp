// What src/core/platform asks of the system, where there is none.
#include <earpoint/core/platform/memory.h>

namespace earpoint {

// WebAssembly's memory has no pages to choose from.
void prefer_large_pages(void* /*memory*/, std::size_t /*bytes*/) {}

}  // namespace earpoint
