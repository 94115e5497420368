#pragma once

#include <filesystem>

namespace earpoint {

/// A folder among the temporary files that is removed with this object, and all that is in it.
class TemporaryFolder {
 public:
  /// @throws InputError if it cannot be created
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace earpoint
