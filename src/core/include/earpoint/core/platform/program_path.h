#pragma once

#include <filesystem>

namespace earpoint {

/// Where the file of the running program lies; links are followed.
/// @return empty if the system does not tell
[[nodiscard]] std::filesystem::path program_path();

/// A path that starts the running program again: the very same one, even if its file has been
/// replaced or removed since it was started.
[[nodiscard]] std::filesystem::path running_program();

}  // namespace earpoint
