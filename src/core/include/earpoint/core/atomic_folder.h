#pragma once

#include <filesystem>

namespace earpoint {

/// A folder that is filled aside and renamed when whole: without commit() nothing of it is left.
/// What a killed process left aside is removed by the next that makes the same folder.
class AtomicFolder {
 public:
  /// @throws InputError if it cannot be made
  explicit AtomicFolder(std::filesystem::path path);
  ~AtomicFolder();
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  /// Where to write.
  [[nodiscard]] const std::filesystem::path& aside() const { return aside_; }

  /// Puts it into place; a folder that is there goes. @throws InputError if that fails
  void commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path aside_;
  bool committed_ = false;
};

}  // namespace earpoint
