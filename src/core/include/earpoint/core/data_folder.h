#pragma once

#include <filesystem>
#include <optional>

namespace earpoint {

/// Where `./dev assets` and `./dev speech` put what they fetch: $EARPOINT_DATA_DIR, else
/// $XDG_DATA_HOME/earpoint, else ~/.local/share/earpoint. An empty variable counts as none.
/// @return nothing if no variable says it, $HOME neither; the folder need not be there
[[nodiscard]] std::optional<std::filesystem::path> data_folder();

}  // namespace earpoint
