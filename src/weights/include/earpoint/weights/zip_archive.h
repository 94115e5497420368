#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

struct zip;

namespace earpoint {

/// A zip archive whose members are stored, not compressed, as PyTorch writes them. So a member is
/// never larger than the file, and all together are not either: that is checked at the start.
class ZipArchive {
 public:
  /// @throws InputError if it is not a zip archive, is cut off, has compressed, encrypted or
  ///         overlapping members, or two of one name
  explicit ZipArchive(const std::filesystem::path& path);

  /// @param bytes  must outlive this
  /// @param where  stands for the file in messages
  ZipArchive(std::span<const std::byte> bytes, std::string_view where);

  /// Name -> size in bytes.
  [[nodiscard]] const std::map<std::string, std::uint64_t>& sizes() const { return sizes_; }
  [[nodiscard]] bool contains(const std::string& name) const { return sizes_.contains(name); }

  /// The whole archive, in bytes.
  [[nodiscard]] std::uint64_t file_size() const { return file_size_; }

  /// @throws InputError if there is no such member, or its bytes are cut off or damaged (CRC-32)
  [[nodiscard]] std::vector<std::byte> read(const std::string& name) const;

 private:
  struct Close {
    void operator()(zip* archive) const;
  };

  void list_members();

  std::string where_;
  std::uint64_t file_size_ = 0;
  std::unique_ptr<zip, Close> archive_;
  std::map<std::string, std::uint64_t> sizes_;
  std::map<std::string, std::uint64_t> indices_;
};

}  // namespace earpoint
