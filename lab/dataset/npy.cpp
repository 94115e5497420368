#include <earpoint/dataset/npy.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <regex>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

static_assert(std::endian::native == std::endian::little, "this code reads little-endian files");

template <typename T>
std::vector<double> widen(const std::byte* data, std::size_t count) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    T value{};
    std::memcpy(&value, data + i * sizeof(T), sizeof(T));
    values[i] = static_cast<double>(value);
  }
  return values;
}

}  // namespace

NumberTable read_npy(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_file(path);
  const std::string name = path.string();
  static constexpr char kMagic[] = "\x93NUMPY";
  constexpr std::size_t kMagicSize = 6;
  constexpr std::uint32_t kLongestHeader = 1024;
  if (bytes.size() < 12 || std::memcmp(bytes.data(), kMagic, kMagicSize) != 0) {
    throw InputError(name, "is not a .npy file");
  }
  const bool short_header = static_cast<int>(bytes[6]) == 1;
  const std::size_t start = short_header ? 10 : 12;
  std::uint32_t header_size = 0;
  std::memcpy(&header_size, bytes.data() + 8, short_header ? 2 : 4);
  if (bytes.size() - start < header_size) throw InputError(name, "its header is truncated");
  // NumPy pads it to 64 or 128 bytes. The regex uses stack in proportion to the length.
  if (header_size > kLongestHeader) throw InputError(name, "its header is too long");
  const std::string header(reinterpret_cast<const char*>(bytes.data()) + start, header_size);

  static const std::regex pattern(
      R"(\{'descr': '<f([48])', 'fortran_order': False, 'shape': \((\d{1,9}), (\d{1,9})\), \}\s*)");
  std::smatch match;
  if (!std::regex_match(header, match, pattern)) {
    throw InputError(name, "expected a 2-D array of floats in C order, found " +
                               header.substr(0, header.find_last_not_of(" \n") + 1));
  }
  NumberTable table;
  const std::size_t width = std::stoul(match[1]);
  table.rows = std::stoul(match[2]);
  table.columns = std::stoul(match[3]);
  const std::size_t count = table.rows * table.columns;
  const std::size_t held = bytes.size() - start - header_size;
  if (held != count * width) throw InputError(name, "its data do not fill the stated shape");
  const std::byte* data = bytes.data() + start + header_size;
  table.values = width == 4 ? widen<float>(data, count) : widen<double>(data, count);
  return table;
}

void write_npy(const std::filesystem::path& path, const NumberTable& table) {
  EARPOINT_CHECK(table.values.size() == table.rows * table.columns);
  std::string header = fmt::format(
      "{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, {}), }}", table.rows, table.columns);
  // Magic, version and length take 10 bytes; data begin at a multiple of 64.
  constexpr std::size_t kPreamble = 10;
  constexpr std::size_t kAlignment = 64;
  const std::size_t end = kPreamble + header.size() + 1;
  header.append((kAlignment - end % kAlignment) % kAlignment, ' ');
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += static_cast<char>(header.size() & 0xFFU);
  bytes += static_cast<char>(header.size() >> 8U);
  bytes += header;
  const std::size_t begin = bytes.size();
  bytes.resize(begin + table.values.size() * sizeof(double));
  std::memcpy(bytes.data() + begin, table.values.data(), table.values.size() * sizeof(double));
  write_file(path, std::string_view(bytes));
}

}  // namespace earpoint
