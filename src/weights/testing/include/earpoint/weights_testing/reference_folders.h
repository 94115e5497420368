#pragma once

#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <vector>

namespace earpoint {

/// Where a kind of reference data lies: what the source tree has of it, and the whole set, of which
/// the former is mostly a part, if EARPOINT_ORACLE_DIR says where that is.
/// @param in_source  below the source tree
/// @param in_whole   below EARPOINT_ORACLE_DIR
/// @return the folder in the source tree first
inline std::vector<std::filesystem::path> reference_folders(std::string_view in_source,
                                                            std::string_view in_whole) {
  std::vector<std::filesystem::path> folders{std::filesystem::path(EARPOINT_SOURCE_DIR) /
                                             in_source};
  if (const char* whole = std::getenv("EARPOINT_ORACLE_DIR")) {
    folders.push_back(std::filesystem::path(whole) / in_whole);
  }
  return folders;
}

}  // namespace earpoint
