#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace earpoint::testing_bytes {

/// Pickles and zip archives made byte by byte, so that tests can make them wrong.

template <typename T>
std::string little_endian(T value) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}

// ---- pickle: each function gives the opcodes that push one value

inline std::string pickled(const std::string& body) { return "\x80\x02" + body + "."; }

inline std::string text(const std::string& value) {
  return "X" + little_endian(static_cast<std::uint32_t>(value.size())) + value;
}

inline std::string integer(std::int64_t value) { return "\x8a\x08" + little_endian(value); }

inline std::string global(const std::string& module, const std::string& name) {
  return "c" + module + "\n" + name + "\n";
}

inline std::string tuple(const std::vector<std::string>& items) {
  std::string bytes = "(";
  for (const std::string& item : items) bytes += item;
  return bytes + "t";
}

inline std::string tuple_of(const std::vector<std::int64_t>& values) {
  std::vector<std::string> items;
  items.reserve(values.size());
  for (const std::int64_t value : values) items.push_back(integer(value));
  return tuple(items);
}

inline std::string dictionary(const std::vector<std::pair<std::string, std::string>>& items) {
  std::string bytes = "}(";
  for (const auto& [key, value] : items) bytes += text(key) + value;
  return bytes + "u";
}

/// A tensor; the defaults are of two float32 at the start of the storage "0".
struct TensorBytes {
  std::string storage_type = global("torch", "FloatStorage");
  std::string key = "0";
  std::int64_t stored = 2;
  std::int64_t offset = 0;
  std::vector<std::int64_t> shape{2};
  std::vector<std::int64_t> strides{1};

  [[nodiscard]] std::string bytes() const {
    const std::string id =
        tuple({text("storage"), storage_type, text(key), text("cpu"), integer(stored)});
    const std::string hooks = global("collections", "OrderedDict") + ")R";
    return global("torch._utils", "_rebuild_tensor_v2") +
           tuple({id + "Q", integer(offset), tuple_of(shape), tuple_of(strides), "\x89", hooks}) +
           "R";
  }
};

// ---- zip

struct Member {
  std::string name;
  std::string data;
  std::uint16_t method = 0;  ///< 0: stored
  std::optional<std::uint32_t> crc = std::nullopt;
  std::optional<std::uint32_t> claimed_size = std::nullopt;
};

/// CRC-32 of ISO 3309, bit by bit.
inline std::uint32_t crc32(const std::string& data) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char c : data) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

/// Source: PKWARE's APPNOTE.TXT, sections 4.3.7, 4.3.12 and 4.3.16.
inline std::vector<std::byte> zipped(const std::vector<Member>& members) {
  using U16 = std::uint16_t;
  using U32 = std::uint32_t;
  std::string local;
  std::string central;
  for (const Member& member : members) {
    const U32 size = member.claimed_size.value_or(static_cast<U32>(member.data.size()));
    const std::string facts =
        little_endian(U16{20}) + little_endian(U16{0}) + little_endian(member.method) +
        little_endian(U32{0x00210000}) + little_endian(member.crc.value_or(crc32(member.data))) +
        little_endian(size) + little_endian(size) +
        little_endian(static_cast<U16>(member.name.size())) + little_endian(U16{0});
    central += "PK\x01\x02" + little_endian(U16{20}) + facts + std::string(10, '\0') +
               little_endian(static_cast<U32>(local.size())) + member.name;
    local += "PK\x03\x04" + facts + member.name + member.data;
  }
  const auto count = static_cast<U16>(members.size());
  const std::string end = "PK\x05\x06" + std::string(4, '\0') + little_endian(count) +
                          little_endian(count) + little_endian(static_cast<U32>(central.size())) +
                          little_endian(static_cast<U32>(local.size())) + std::string(2, '\0');
  const std::string all = local + central + end;
  std::vector<std::byte> bytes(all.size());
  std::memcpy(bytes.data(), all.data(), all.size());
  return bytes;
}

}  // namespace earpoint::testing_bytes
