#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace earpoint {

/// The whole file as bytes.
/// @throws InputError if it is missing, not a regular file or cannot be read
std::vector<std::byte> read_file(const std::filesystem::path& path);

/// The whole file as text.
/// @throws InputError as read_file
std::string read_text_file(const std::filesystem::path& path);

/// A file written aside and renamed when whole: a crash, a kill or a full disk leaves either the
/// old file or the new one, never half of it. Write to `temporary_path()`, then `commit()`;
/// without commit() the destructor removes what was written.
class AtomicFile {
 public:
  /// @throws InputError if the folder is missing or not writable
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// In the same folder, with the same extension (encoders choose their format by it).
  [[nodiscard]] const std::filesystem::path& temporary_path() const { return temporary_path_; }

  /// Flushes the written file to disk and renames it into place.
  /// @throws InputError if that fails
  void commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_path_;
  bool committed_ = false;
};

/// Writes a whole file by AtomicFile.
/// @throws InputError if it cannot be written, e.g. on a full disk
void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);

}  // namespace earpoint
