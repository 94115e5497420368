#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include <earpoint/core/error.h>
#include <earpoint/core/file.h>

namespace earpoint {
namespace fs = std::filesystem;

namespace {

[[noreturn]] void throw_errno(const fs::path& path, const char* what, int error) {
  const char* mend = error == ENOSPC   ? "free some space or write elsewhere"
                     : error == EACCES ? "check its permissions"
                                       : "";
  throw InputError(path.string(),
                   std::string(what) + " (" + std::generic_category().message(error) + ")", mend);
}

template <typename Buffer>
Buffer read_whole(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw InputError(path.string(), "no such file");
  if (!fs::is_regular_file(status)) throw InputError(path.string(), "is not a file");

  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw_errno(path, "cannot be opened", errno);
  Buffer buffer;
  buffer.resize(fs::file_size(path));
  stream.read(reinterpret_cast<char*>(buffer.data()), static_cast<std::streamsize>(buffer.size()));
  if (stream.gcount() != static_cast<std::streamsize>(buffer.size())) {
    throw InputError(path.string(), "could not be read to its end");
  }
  return buffer;
}

}  // namespace

std::vector<std::byte> read_file(const fs::path& path) {
  return read_whole<std::vector<std::byte>>(path);
}

std::string read_text_file(const fs::path& path) { return read_whole<std::string>(path); }

AtomicFile::AtomicFile(fs::path path) : path_(std::move(path)) {
  const fs::path folder = path_.has_parent_path() ? path_.parent_path() : fs::path(".");
  if (!fs::is_directory(folder)) {
    throw InputError(path_.string(), "its folder does not exist", "make " + folder.string());
  }
  if (fs::is_directory(path_)) throw InputError(path_.string(), "is a folder, not a file");
  temporary_path_ = folder / (std::string(".").append(path_.stem().string()) + "." +
                              std::to_string(::getpid()) + ".partial" + path_.extension().string());

  // Finds out now, not after an hour of work, that nothing can be written here.
  const int descriptor =
      ::open(temporary_path_.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0666);
  if (descriptor < 0) throw_errno(path_, "cannot be written", errno);
  ::close(descriptor);
}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  std::error_code ignored;
  fs::remove(temporary_path_, ignored);
}

void AtomicFile::commit() {
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

void write_file(const fs::path& path, std::span<const std::byte> bytes) {
  AtomicFile file(path);
  std::FILE* stream = std::fopen(file.temporary_path().c_str(), "wb");
  if (stream == nullptr) throw_errno(path, "cannot be written", errno);
  const std::size_t written = std::fwrite(bytes.data(), 1, bytes.size(), stream);
  const int write_error = errno;
  // A full disk may show only when the last buffer is flushed.
  const bool closed = std::fclose(stream) == 0;
  if (written != bytes.size()) throw_errno(path, "cannot be written", write_error);
  if (!closed) throw_errno(path, "cannot be written", errno);
  file.commit();
}

void write_file(const fs::path& path, std::string_view text) {
  write_file(path, std::as_bytes(std::span(text.data(), text.size())));
}

}  // namespace earpoint
