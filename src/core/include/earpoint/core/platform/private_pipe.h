#pragma once

#include <array>

namespace earpoint {

/// A pipe that programs which this process starts do not inherit, not even those that another
/// thread starts meanwhile.
/// @return the ends to read from and to write to
/// @throws std::system_error if the process has no descriptors left
[[nodiscard]] std::array<int, 2> private_pipe();

}  // namespace earpoint
