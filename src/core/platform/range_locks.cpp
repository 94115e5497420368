#include <earpoint/core/platform/range_locks.h>

#include <cerrno>

#include <fcntl.h>
#include <unistd.h>

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

bool try_lock_range(int descriptor, std::int64_t first, std::int64_t count) {
  struct flock wanted = range(F_WRLCK, first, count);
  if (::fcntl(descriptor, F_OFD_SETLK, &wanted) == 0) return true;
  return errno != EAGAIN && errno != EACCES;  // other errors: no locks on this file
}

void lock_range(int descriptor, std::int64_t first, std::int64_t count) {
  struct flock wanted = range(F_WRLCK, first, count);
  while (::fcntl(descriptor, F_OFD_SETLKW, &wanted) != 0 && errno == EINTR) {
  }
}

void unlock_range(int descriptor, std::int64_t first, std::int64_t count) {
  struct flock given_up = range(F_UNLCK, first, count);
  ::fcntl(descriptor, F_OFD_SETLK, &given_up);
}

bool others_hold_range(int descriptor, std::int64_t first, std::int64_t count) {
  struct flock found = range(F_WRLCK, first, count);
  return ::fcntl(descriptor, F_OFD_GETLK, &found) == 0 && found.l_type != F_UNLCK;
}

}  // namespace earpoint
