#include <earpoint/core/range_lock.h>

#include "lock_descriptors.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>

#include <earpoint/core/platform/range_locks.h>
#include <earpoint/error.h>

namespace earpoint {

RangeLock::RangeLock(std::filesystem::path file) : file_(std::move(file)) {
  descriptor_ = ::open(file_.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
  if (descriptor_ < 0) {
    throw InputError(file_.string(),
                     "cannot be opened (" + std::generic_category().message(errno) + ")",
                     "check the folder's permissions");
  }
  close_in_children(descriptor_);
}

RangeLock::~RangeLock() { close_lock(descriptor_); }

bool RangeLock::try_lock(std::int64_t first, std::int64_t count) {
  EARPOINT_CHECK(first >= 0 && count > 0);
  return try_lock_range(descriptor_, first, count);
}

void RangeLock::lock(std::int64_t first, std::int64_t count) {
  EARPOINT_CHECK(first >= 0 && count > 0);
  lock_range(descriptor_, first, count);
}

void RangeLock::unlock(std::int64_t first, std::int64_t count) {
  unlock_range(descriptor_, first, count);
}

bool RangeLock::others_hold_from(std::int64_t first) const {
  return others_hold_range(descriptor_, first, kToTheEnd);
}

}  // namespace earpoint
