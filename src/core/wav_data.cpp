#include <earpoint/core/wav_data.h>

#include <array>
#include <cstring>
#include <fstream>
#include <string_view>

namespace earpoint {
namespace {

constexpr std::uint64_t kOpenLength = 0x7FFFF000;  // written where the length is not known yet
constexpr std::uint64_t kMiscounted_bytes = 64;    // more than a header that was counted as samples
constexpr std::uint64_t kLongForm = 0xFFFFFFFF;

std::uint64_t little_endian(const char* bytes, int count) {
  std::uint64_t value = 0;
  for (int i = count - 1; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

}  // namespace

bool WavData::goes_to_the_end() const {
  if (claimed == 0) return present > 0;
  if (claimed <= present) return false;
  return claimed - present <= kMiscounted_bytes || (claimed >= kOpenLength && claimed <= kLongForm);
}

std::optional<WavData> find_wav_data(const std::filesystem::path& path) {
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  std::array<char, 24> head{};
  if (error || !file.read(head.data(), 12)) return std::nullopt;
  const std::string_view mark(head.data(), 4);
  const bool is_long = mark == "RF64";
  if ((mark != "RIFF" && !is_long) || std::string_view(head.data() + 8, 4) != "WAVE") {
    return std::nullopt;
  }
  std::uint64_t long_length = 0;
  // Chunks of a 4-byte name, a 4-byte length and the content, padded to an even length.
  for (std::uint64_t position = 12; position + 8 <= size;) {
    file.clear();
    file.seekg(static_cast<std::streamoff>(position));
    file.read(head.data(), head.size());
    const std::string_view name(head.data(), 4);
    std::uint64_t length = little_endian(head.data() + 4, 4);
    if (name == "ds64" && file.gcount() == 24) long_length = little_endian(head.data() + 16, 8);
    if (name == "data") {
      if (is_long && length == kLongForm) length = long_length;
      return WavData{position + 8, length, size - position - 8};
    }
    position += 8 + length + length % 2;
  }
  return std::nullopt;
}

}  // namespace earpoint
