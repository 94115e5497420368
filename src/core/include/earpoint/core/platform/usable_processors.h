#pragma once

namespace earpoint {

/// How many processors this process may run on (taskset and containers may leave it fewer than
/// there are).
/// @return >= 1
[[nodiscard]] int usable_processors();

}  // namespace earpoint
