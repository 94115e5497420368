#include "sound_container.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <numeric>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include <earpoint/core/wav_data.h>
#include <earpoint/error.h>

namespace earpoint {
namespace fs = std::filesystem;

namespace {

constexpr const char* kHint = "copy or export it again";

/// A file read at given places; what lies behind its end is missing from the result.
class FileBytes {
 public:
  explicit FileBytes(const fs::path& path)
      : path_(path), stream_(path, std::ios::binary), size_(fs::file_size(path)) {}

  [[nodiscard]] const fs::path& path() const { return path_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }

  std::string_view at(std::uint64_t position, std::size_t count) {
    buffer_.resize(count);
    stream_.clear();
    stream_.seekg(static_cast<std::streamoff>(position));
    stream_.read(buffer_.data(), static_cast<std::streamsize>(count));
    return {buffer_.data(),
            static_cast<std::size_t>(std::max<std::streamsize>(0, stream_.gcount()))};
  }

 private:
  fs::path path_;
  std::ifstream stream_;
  std::uint64_t size_;
  std::vector<char> buffer_;
};

std::uint64_t little_endian(std::string_view bytes) {
  return std::accumulate(
      bytes.rbegin(), bytes.rend(), std::uint64_t{0},
      [](std::uint64_t value, char byte) { return value << 8 | static_cast<unsigned char>(byte); });
}

[[noreturn]] void throw_cut(const fs::path& path, std::uint64_t claimed, std::uint64_t present) {
  throw InputError(
      path.string(),
      fmt::format("is truncated: its header promises {} bytes of samples, {} are there", claimed,
                  present),
      kHint);
}

void check_wav(const fs::path& path) {
  const std::optional<WavData> data = find_wav_data(path);
  if (!data) throw InputError(path.string(), "is truncated: it has no data chunk", kHint);
  if (data->is_cut()) throw_cut(path, data->claimed, data->present);
}

/// Chunks of a 16-byte name, an 8-byte length that counts both, and the content, padded to 8 bytes.
void check_w64(FileBytes& file) {
  for (std::uint64_t position = 40; position + 24 <= file.size();) {
    const std::string_view head = file.at(position, 24);
    const std::uint64_t length = little_endian(head.substr(16, 8));
    if (length < 24) break;
    if (head.substr(0, 4) == "data") {
      const std::uint64_t present = file.size() - position - 24;
      if (length - 24 > present) throw_cut(file.path(), length - 24, present);
      return;
    }
    if (length > file.size()) break;
    position += (length + 7) / 8 * 8;
  }
  throw InputError(file.path().string(), "is truncated: it has no data chunk", kHint);
}

/// The last page carries a mark and must be whole: 27 bytes, a table of segment lengths, segments.
void check_ogg(FileBytes& file) {
  constexpr std::size_t kPageHeader = 27;
  constexpr std::size_t kLargestPage = 65307;
  constexpr char kEndOfStream = 4;
  const std::uint64_t start = file.size() - std::min<std::uint64_t>(file.size(), 2 * kLargestPage);
  const std::string_view tail = file.at(start, static_cast<std::size_t>(file.size() - start));
  const std::size_t found = tail.rfind("OggS");
  if (found != std::string_view::npos && found + kPageHeader <= tail.size()) {
    const std::string_view page = tail.substr(found);
    const auto segments = static_cast<std::size_t>(static_cast<unsigned char>(page[26]));
    const std::string_view table = page.substr(kPageHeader, segments);
    std::size_t length = kPageHeader + segments;
    for (const char segment : table) length += static_cast<unsigned char>(segment);
    if ((page[5] & kEndOfStream) != 0 && table.size() == segments && length <= page.size()) return;
  }
  throw InputError(file.path().string(), "is truncated: its last Ogg page is missing or cut",
                   kHint);
}

}  // namespace

void check_container_is_whole(const fs::path& path) {
  FileBytes file(path);
  const std::string_view mark = file.at(0, 4);
  if (mark == "RIFF" || mark == "RF64") {
    check_wav(path);
  } else if (mark == "riff") {
    check_w64(file);
  } else if (mark == "OggS") {
    check_ogg(file);
  }
}

}  // namespace earpoint
