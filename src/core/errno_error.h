#pragma once

// Private to the module.

#include <cerrno>
#include <filesystem>
#include <string>
#include <system_error>

#include <earpoint/error.h>

namespace earpoint {

/// @throws InputError that says what failed and how the system explains it
[[noreturn]] inline void throw_errno(const std::filesystem::path& path, const std::string& what,
                                     int error) {
  const char* hint = error == ENOSPC   ? "free some space, or choose another disk"
                     : error == EACCES ? "check its permissions"
                                       : "";
  throw InputError(path.string(), what + " (" + std::generic_category().message(error) + ")", hint);
}

}  // namespace earpoint
