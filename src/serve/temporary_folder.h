#pragma once

#include <filesystem>

namespace earpoint {

/// A folder of its own that vanishes with this object.
class TemporaryFolder {
 public:
  /// @throws std::system_error if it cannot be made
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace earpoint
