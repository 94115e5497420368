#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace earpoint {

/// The scenes of a split of Replay-NVAS v3, as the released loader lists them.
/// @throws InputError if the split is not train, val or test
std::vector<std::string_view> replay_scenes(const std::string& split);

}  // namespace earpoint
