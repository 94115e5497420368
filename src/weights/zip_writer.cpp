#include <earpoint/weights/zip_writer.h>

#include <array>
#include <concepts>
#include <limits>
#include <utility>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr std::size_t kAlignment = 64;
constexpr std::size_t kLocalHeader = 30;
constexpr std::uint16_t kPaddingField = 0x4246;  // "FB", PyTorch's
constexpr std::uint16_t kStored = 0;
constexpr std::uint16_t kNameIsUtf8 = 1U << 11U;
constexpr std::uint16_t kFirstDay = (1U << 5U) | 1U;  // of 1980, the format's earliest

/// CRC-32 as in zip: the polynomial 0x04C11DB7, reflected.
std::uint32_t checksum(std::span<const std::byte> bytes) {
  static const std::array<std::uint32_t, 256> table = [] {
    std::array<std::uint32_t, 256> result{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit) {
        value = (value & 1U) != 0U ? 0xEDB88320U ^ (value >> 1U) : value >> 1U;
      }
      result[i] = value;
    }
    return result;
  }();
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::byte b : bytes) {
    crc = table[(crc ^ std::to_integer<std::uint32_t>(b)) & 0xFFU] ^ (crc >> 8U);
  }
  return ~crc;
}

template <std::unsigned_integral T>
void append(std::vector<std::byte>& bytes, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bytes.push_back(static_cast<std::byte>(value >> (8U * i)));
  }
}

void append(std::vector<std::byte>& bytes, std::string_view text) {
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
}

std::uint32_t fitting(std::size_t size) {
  if (size > std::numeric_limits<std::uint32_t>::max()) {
    throw InputError("the checkpoint", "would be larger than 4 GB");
  }
  return static_cast<std::uint32_t>(size);
}

}  // namespace

void ZipWriter::add(std::string_view name, std::span<const std::byte> bytes) {
  EARPOINT_CHECK(members_ < std::numeric_limits<std::uint16_t>::max());
  const std::uint32_t offset = fitting(archive_.size());
  const std::uint32_t size = fitting(bytes.size());
  // An extra field has a head of four bytes.
  std::size_t padding = 4;
  while ((archive_.size() + kLocalHeader + name.size() + padding) % kAlignment != 0) ++padding;

  std::vector<std::byte> shared;  // by the member's own header and the directory's
  append(shared, std::uint16_t{20});
  append(shared, kNameIsUtf8);
  append(shared, kStored);
  append(shared, std::uint16_t{0});
  append(shared, kFirstDay);
  append(shared, checksum(bytes));
  append(shared, size);
  append(shared, size);
  append(shared, static_cast<std::uint16_t>(name.size()));

  append(archive_, std::uint32_t{0x04034B50});
  archive_.insert(archive_.end(), shared.begin(), shared.end());
  append(archive_, static_cast<std::uint16_t>(padding));
  append(archive_, name);
  append(archive_, kPaddingField);
  append(archive_, static_cast<std::uint16_t>(padding - 4));
  archive_.resize(archive_.size() + padding - 4);
  archive_.insert(archive_.end(), bytes.begin(), bytes.end());

  append(directory_, std::uint32_t{0x02014B50});
  append(directory_, std::uint16_t{20});
  directory_.insert(directory_.end(), shared.begin(), shared.end());
  append(directory_, std::uint16_t{0});  // extra field
  append(directory_, std::uint16_t{0});  // comment
  append(directory_, std::uint16_t{0});  // disk
  append(directory_, std::uint16_t{0});  // internal attributes
  append(directory_, std::uint32_t{0});  // external attributes
  append(directory_, offset);
  append(directory_, name);
  ++members_;
}

std::vector<std::byte> ZipWriter::finish() {
  const std::uint32_t start = fitting(archive_.size());
  const std::uint32_t size = fitting(directory_.size());
  archive_.insert(archive_.end(), directory_.begin(), directory_.end());
  append(archive_, std::uint32_t{0x06054B50});
  append(archive_, std::uint16_t{0});
  append(archive_, std::uint16_t{0});
  append(archive_, members_);
  append(archive_, members_);
  append(archive_, size);
  append(archive_, start);
  append(archive_, std::uint16_t{0});
  return std::move(archive_);
}

}  // namespace earpoint
