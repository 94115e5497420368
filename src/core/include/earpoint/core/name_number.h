#pragma once

#include <cstdint>
#include <string_view>

namespace earpoint {

/// A number for a name, the same on every machine: for the keys of a RandomStream, or to tell texts
/// apart. Source: Fowler, Noll and Vo, FNV-1a, 64 bits.
[[nodiscard]] constexpr std::uint64_t name_number(std::string_view name) {
  std::uint64_t hash = 0xCBF29CE484222325U;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
  return hash;
}

}  // namespace earpoint
