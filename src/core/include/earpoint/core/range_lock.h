#pragma once

#include <cstdint>
#include <filesystem>

namespace earpoint {

/// Locks between processes that work in one folder: on numbered parts, kept as byte ranges of a
/// lock file. The kernel releases them when the process ends, however it ends, and the empty file
/// stays.
///
/// Locks belong to this object: two of them in one process exclude each other too. Over NFS they
/// work as far as the server keeps byte-range locks; on a file system without locks every request
/// succeeds.
class RangeLock {
 public:
  /// Opens the lock file; makes it if it is not there.
  /// @throws InputError if it cannot be opened for writing
  explicit RangeLock(std::filesystem::path file);
  ~RangeLock();
  RangeLock(const RangeLock&) = delete;
  RangeLock& operator=(const RangeLock&) = delete;

  /// Locks the parts [first, first + count).
  /// @param first  >= 0
  /// @param count  > 0
  /// @return false if another holds one of them; then nothing is locked
  [[nodiscard]] bool try_lock(std::int64_t first, std::int64_t count);
  /// The same, and waits for it.
  void lock(std::int64_t first, std::int64_t count);
  void unlock(std::int64_t first, std::int64_t count);

  /// Whether another holds any part from `first` on.
  [[nodiscard]] bool others_hold_from(std::int64_t first) const;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace earpoint
