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

/// Makes the folder, and those above it, unless it is there.
/// @return  its path
/// @throws InputError if it cannot be made
const std::filesystem::path& create_folder(const std::filesystem::path& folder);

/// A file written aside and renamed when whole: a crash, a kill or a full disk leaves either the
/// old file or the new one, never half of it. Write to `temporary_path()`, then `commit()`;
/// without commit() the destructor removes what was written. What a killed process left aside is
/// taken over by the next that writes the same file. A symbolic link is written through; what is
/// neither file nor folder (a pipe, a device) gets the bytes when they are whole, and the path "-"
/// is standard output.
class AtomicFile {
 public:
  /// @throws InputError if the folder is missing or not writable
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// In the same folder if it is to be renamed, with the same extension (encoders choose their
  /// format by it).
  [[nodiscard]] const std::filesystem::path& temporary_path() const { return temporary_path_; }

  /// Flushes the written file to disk and renames it into place.
  /// @throws InputError if that fails
  void commit();

 private:
  void open_beside();
  void open_elsewhere();
  void send();

  std::filesystem::path path_;
  std::filesystem::path temporary_path_;
  int descriptor_ = -1;     ///< holds the lock that tells others that the temporary file is in use
  int slot_ = -1;           ///< among the files that a signal removes; -1 if there was no room
  bool is_stream_ = false;  ///< the bytes are sent there, nothing is renamed
  bool committed_ = false;
};

/// The place that AtomicFile(path) would write to, by its one absolute name: two paths are the same
/// file if this is the same, whether or not it is there.
[[nodiscard]] std::filesystem::path written_place(const std::filesystem::path& path);

/// From now on SIGINT, SIGTERM, SIGHUP and SIGPIPE, where they are not ignored, first remove what
/// AtomicFile has written aside, and then end the process as they always do.
void remove_partial_files_on_signals();

/// What comes from a pipe or from standard input ("-"), stored so that it can be read more than
/// once.
/// @return  the path itself if it is no such thing; else one by which this process reads the stored
///          bytes, which vanish when it ends
/// @throws InputError if it cannot be read or stored
[[nodiscard]] std::filesystem::path stored_input(const std::filesystem::path& path);

/// Writes a whole file by AtomicFile.
/// @throws InputError if it cannot be written, e.g. on a full disk
void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
void write_file(const std::filesystem::path& path, std::string_view text);

}  // namespace earpoint
