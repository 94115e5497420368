#pragma once

namespace earpoint {

/// Channels of a binaural sound: left, right.
inline constexpr int kEars = 2;

}  // namespace earpoint
