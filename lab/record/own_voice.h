#pragma once

#include <span>
#include <vector>

namespace earpoint {

/// @return the value that a share of them stays below; @param values at least one
[[nodiscard]] float quantile(std::vector<float> values, double share);

/// How loud each near microphone has the voice of who wears it, dB: voices are compared re this, as
/// microphones have gains of their own. It is learned where one microphone is clearly the loudest,
/// each re its own quiet moments. Somebody who never speaks has heard others alone: their voice is
/// taken to be as far above their microphone's quiet moments as those of the others are.
/// @param levels  [microphone][moment], dB, at least one of each
[[nodiscard]] std::vector<float> own_voice_levels(std::span<const std::vector<float>> levels);

}  // namespace earpoint
