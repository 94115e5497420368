#include "errno_error.h"
#include "lock_descriptors.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <earpoint/core/file.h>
#include <earpoint/core/platform/range_locks.h>
#include <earpoint/error.h>

namespace earpoint {
namespace fs = std::filesystem;

namespace {

/// Paths to unlink when a signal ends the process. The thread that takes a pointer out owns it.
constexpr int kSlots = 512;
std::array<std::atomic<char*>, kSlots> partial_files{};
static_assert(std::atomic<char*>::is_always_lock_free, "a signal handler may take no lock");

int remember(const fs::path& path) {
  char* copy = ::strdup(path.c_str());
  if (copy == nullptr) return -1;
  for (int slot = 0; slot < kSlots; ++slot) {
    char* empty = nullptr;
    if (partial_files[slot].compare_exchange_strong(empty, copy)) return slot;
  }
  std::free(copy);
  return -1;
}

void forget(int slot) {
  if (slot >= 0) std::free(partial_files[slot].exchange(nullptr));
}

/// The process that owns the paths: children leave their parent's files alone.
pid_t writer = 0;

/// Makes only calls that are safe in a signal handler.
void remove_and_end(int signal) {
  for (auto& slot : partial_files) {
    if (writer != ::getpid()) break;
    if (const char* path = slot.exchange(nullptr)) ::unlink(path);
  }
  std::signal(signal, SIG_DFL);
  ::raise(signal);
}

/// Where a chain of symbolic links ends, whether or not something is there.
fs::path behind_links(fs::path path) {
  constexpr int kMostLinks = 40;  // as the kernel
  std::error_code error;
  for (int i = 0; i < kMostLinks && fs::is_symlink(path, error); ++i) {
    path = path.parent_path() / fs::read_symlink(path, error);
  }
  return path;
}

bool is_stream(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return path == "-" || (fs::exists(status) && !fs::is_regular_file(status));
}

/// Takes the lock that says that this file is being written. @return false if another has it, or
/// has just renamed or removed the file
bool take(int descriptor, const fs::path& path) {
  if (!try_lock_range(descriptor, 0, kToTheEnd)) return false;
  struct stat opened {};
  struct stat named {};
  return ::fstat(descriptor, &opened) == 0 && ::stat(path.c_str(), &named) == 0 &&
         opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
}

/// "there.wav" is written as ".there.partial.wav", and by a second writer at the same time as
/// ".there.1.partial.wav".
std::string partial_name(const fs::path& path, int number) {
  const std::string mark = number == 0 ? "" : "." + std::to_string(number);
  return "." + path.stem().string() + mark + ".partial" + path.extension().string();
}

/// Removes what a killed process wrote. @return false if nothing is there or it is in use
bool remove_if_left(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool is_left = take(descriptor, path);
  if (is_left) ::unlink(path.c_str());
  ::close(descriptor);
  return is_left;
}

/// @return 0, or the error
int write_all(int descriptor, const char* bytes, std::size_t count) {
  for (std::size_t done = 0; done < count;) {
    const ssize_t got = ::write(descriptor, bytes + done, count - done);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return got < 0 ? errno : ENOSPC;
    done += static_cast<std::size_t>(got);
  }
  return 0;
}

/// @return 0, or the error
int copy_all(int from, int to) {
  std::array<char, 1 << 16> block{};
  while (true) {
    const ssize_t got = ::read(from, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return errno;
    if (got == 0) return 0;
    if (const int error = write_all(to, block.data(), static_cast<std::size_t>(got))) return error;
  }
}

std::string name_of(const fs::path& path) {
  return path == "-" ? "standard output" : path.string();
}

}  // namespace

AtomicFile::AtomicFile(fs::path path) : path_(behind_links(std::move(path))) {
  if (fs::is_directory(path_)) throw InputError(path_.string(), "is a folder, not a file");
  is_stream_ = is_stream(path_);
  if (is_stream_) {
    open_elsewhere();
  } else {
    open_beside();
  }
  close_in_children(descriptor_);
  slot_ = remember(temporary_path_);
}

void AtomicFile::open_beside() {
  const fs::path folder = path_.has_parent_path() ? path_.parent_path() : fs::path(".");
  if (!fs::is_directory(folder)) {
    throw InputError(path_.string(), "its folder does not exist", "make " + folder.string());
  }
  // Finds out now, not after an hour of work, that nothing can be written here. A name that a
  // killed process left is free again: its lock ended with it.
  constexpr int kMostWriters = 1000;
  int number = 0;
  for (; number < kMostWriters && descriptor_ < 0; ++number) {
    temporary_path_ = folder / partial_name(path_, number);
    descriptor_ = ::open(temporary_path_.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
    if (descriptor_ < 0) throw_errno(path_, "cannot be written", errno);
    if (!take(descriptor_, temporary_path_)) ::close(std::exchange(descriptor_, -1));
  }
  if (descriptor_ < 0) {
    throw InputError(path_.string(), "is being written by many processes", "wait for them");
  }
  if (::ftruncate(descriptor_, 0) != 0) throw_errno(path_, "cannot be written", errno);
  // If several writers were killed, their files are left too.
  while (remove_if_left(folder / partial_name(path_, number))) ++number;
}

void AtomicFile::open_elsewhere() {
  const std::string extension = path_.extension().string();
  std::string name = (fs::temp_directory_path() / ("earpoint-XXXXXX" + extension)).string();
  descriptor_ = ::mkostemps(name.data(), static_cast<int>(extension.size()), O_CLOEXEC);
  if (descriptor_ < 0) throw_errno(name, "cannot be written", errno);
  temporary_path_ = name;
}

AtomicFile::~AtomicFile() {
  if (!committed_) {
    std::error_code ignored;
    fs::remove(temporary_path_, ignored);
  }
  forget(slot_);
  if (descriptor_ >= 0) close_lock(descriptor_);
}

void AtomicFile::send() {
  const int from = ::open(temporary_path_.c_str(), O_RDONLY | O_CLOEXEC);
  const int to = path_ == "-" ? ::dup(STDOUT_FILENO) : ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
  const int error = from < 0 || to < 0 ? errno : copy_all(from, to);
  if (from >= 0) ::close(from);
  if (to >= 0 && ::close(to) != 0 && error == 0)
    throw_errno(name_of(path_), "cannot be written", errno);
  if (error != 0) throw_errno(name_of(path_), "cannot be written", error);
}

void AtomicFile::commit() {
  if (is_stream_) {
    send();
    return;
  }
  const int descriptor = ::open(temporary_path_.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) throw_errno(path_, "cannot be written", errno);
  const int synced = ::fsync(descriptor);
  const int sync_error = errno;
  ::close(descriptor);
  if (synced != 0) throw_errno(path_, "cannot be flushed to disk", sync_error);

  std::error_code error;
  fs::rename(temporary_path_, path_, error);
  if (error) throw_errno(path_, "cannot be renamed into place", error.value());
  committed_ = true;
}

fs::path written_place(const fs::path& path) {
  return path == "-" ? path : fs::weakly_canonical(fs::absolute(behind_links(path)));
}

void remove_partial_files_on_signals() {
  writer = ::getpid();
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
    struct sigaction found {};
    if (::sigaction(signal, nullptr, &found) == 0 && found.sa_handler == SIG_IGN) continue;
    struct sigaction wanted {};
    wanted.sa_handler = remove_and_end;
    ::sigemptyset(&wanted.sa_mask);
    ::sigaction(signal, &wanted, nullptr);
  }
}

fs::path stored_input(const fs::path& path) {
  std::error_code ignored;
  const bool is_standard = path == "-";
  if (!is_standard && !fs::is_fifo(fs::status(path, ignored))) return path;
  const std::string name = is_standard ? "standard input" : path.string();
  const int from = is_standard ? ::dup(STDIN_FILENO) : ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (from < 0) throw_errno(name, "cannot be read", errno);
  std::string stored = (fs::temp_directory_path() / "earpoint-XXXXXX").string();
  // Kept open to the end of the process, and without a name, so that it is never left behind.
  const int to = ::mkostemp(stored.data(), O_CLOEXEC);
  if (to >= 0) ::unlink(stored.c_str());
  const int error = to < 0 ? errno : copy_all(from, to);
  ::close(from);
  if (error != 0)
    throw_errno(name, "cannot be stored in " + fs::temp_directory_path().string(), error);
  return "/dev/fd/" + std::to_string(to);
}

}  // namespace earpoint
