#include <earpoint/core/range_lock.h>

#include "lock_descriptors.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include <earpoint/core/error.h>

namespace earpoint {
namespace {

struct flock range(short type, std::int64_t first, std::int64_t count) {
  struct flock range = {};
  range.l_type = type;
  range.l_whence = SEEK_SET;
  range.l_start = first;
  range.l_len = count;
  return range;
}

}  // namespace

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
  struct flock wanted = range(F_WRLCK, first, count);
  if (::fcntl(descriptor_, F_OFD_SETLK, &wanted) == 0) return true;
  return errno != EAGAIN && errno != EACCES;  // others: there are no locks here
}

void RangeLock::lock(std::int64_t first, std::int64_t count) {
  EARPOINT_CHECK(first >= 0 && count > 0);
  struct flock wanted = range(F_WRLCK, first, count);
  while (::fcntl(descriptor_, F_OFD_SETLKW, &wanted) != 0 && errno == EINTR) {
  }
}

void RangeLock::unlock(std::int64_t first, std::int64_t count) {
  struct flock given_up = range(F_UNLCK, first, count);
  ::fcntl(descriptor_, F_OFD_SETLK, &given_up);
}

bool RangeLock::others_hold_from(std::int64_t first) const {
  struct flock found = range(F_WRLCK, first, /*count: to the end=*/0);
  return ::fcntl(descriptor_, F_OFD_GETLK, &found) == 0 && found.l_type != F_UNLCK;
}

}  // namespace earpoint
