#include <earpoint/core/file.h>

#include "errno_error.h"

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <system_error>

#include <earpoint/error.h>

namespace earpoint {
namespace fs = std::filesystem;

namespace {

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
    throw InputError(path.string(), "could not be read completely");
  }
  return buffer;
}

}  // namespace

std::vector<std::byte> read_file(const fs::path& path) {
  return read_whole<std::vector<std::byte>>(path);
}

std::string read_text_file(const fs::path& path) { return read_whole<std::string>(path); }

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

const fs::path& create_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(folder.string(), "cannot be created: " + error.message());
  return folder;
}

void write_file(const fs::path& path, std::string_view text) {
  write_file(path, std::as_bytes(std::span(text.data(), text.size())));
}

}  // namespace earpoint
