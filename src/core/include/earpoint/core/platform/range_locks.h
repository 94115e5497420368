#pragma once

#include <cstdint>

namespace earpoint {

/// Locks on ranges of an open file's bytes that belong to the open file, not to the process: two
/// descriptors that one process opened exclude each other too, and closing one does not give up the
/// other's. They end with the last copy of the descriptor, however its process ends. The bytes need
/// not exist.
///
/// On a file system without locks every request succeeds.

/// The last range reaches to the end of any file.
constexpr std::int64_t kToTheEnd = 0;

/// @param first  >= 0
/// @param count  > 0, or kToTheEnd
/// @return false if another holds a byte of the range; then nothing is locked
[[nodiscard]] bool try_lock_range(int descriptor, std::int64_t first, std::int64_t count);
/// The same, and waits for it.
void lock_range(int descriptor, std::int64_t first, std::int64_t count);
void unlock_range(int descriptor, std::int64_t first, std::int64_t count);
/// Whether another holds a byte of the range.
[[nodiscard]] bool others_hold_range(int descriptor, std::int64_t first, std::int64_t count);

}  // namespace earpoint
