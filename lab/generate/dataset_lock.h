#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <earpoint/core/range_lock.h>
#include <earpoint/generate/work_plan.h>

namespace earpoint {

/// Keeps processes that make one data set apart: each conversation is made by one of them, and one
/// at a time writes what concerns the whole set.
class DatasetLock {
 public:
  /// Makes the data set's folder if it is not there.
  /// @throws InputError if it cannot be written
  DatasetLock(const std::filesystem::path& folder, const WorkOrder& order);

  /// The right to write the record, the metadata and the pair lists: std::lock_guard waits for it.
  void lock() { ranges_.lock(kWhole, 1); }
  void unlock() { ranges_.unlock(kWhole, 1); }

  /// Takes conversations until this object ends.
  /// @throws InputError if another process makes one of them
  void take(const std::vector<WorkItem>& items);

  /// Whether another process makes conversations of this set.
  [[nodiscard]] bool others_work() const { return ranges_.others_hold_from(kFirstItem); }

  /// The lock file's name in the folder.
  static constexpr const char* kFile = ".lock";

 private:
  static constexpr std::int64_t kWhole = 0;
  static constexpr std::int64_t kFirstItem = 1;

  std::filesystem::path folder_;
  std::int64_t conversations_;
  RangeLock ranges_;
};

}  // namespace earpoint
