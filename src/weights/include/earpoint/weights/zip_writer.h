#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace earpoint {

/// A zip archive in memory whose members are stored, not compressed, each member's bytes beginning
/// at a multiple of 64, as PyTorch writes and maps them. Source: PKWARE's APPNOTE 6.3.9, 4.3; the
/// padding is an extra field, as PyTorch makes it.
class ZipWriter {
 public:
  /// @throws InputError if the archive would be larger than the 4 GB that the format's 32-bit
  ///         fields can say
  void add(std::string_view name, std::span<const std::byte> bytes);

  /// @return the archive; nothing can be added afterwards
  [[nodiscard]] std::vector<std::byte> finish();

 private:
  std::vector<std::byte> archive_;
  std::vector<std::byte> directory_;
  std::uint16_t members_ = 0;
};

}  // namespace earpoint
