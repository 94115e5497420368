#pragma once

#include <cstddef>

namespace earpoint::kernels {

/// Columns of a panel: what one tile computes at a time. A multiple of the lanes of every
/// instruction set; with the columns of two panels, weights and sums it fits the second-level
/// cache.
inline constexpr std::ptrdiff_t kTileColumns = 32;

/// Rows of packed weights that lie together: channels of the 1x1 convolutions, or the filter and
/// gate rows of half as many channels: f0 f1 g0 g1 f2 f3 g2 g3.
inline constexpr std::ptrdiff_t kGroupRows = 8;
inline constexpr std::ptrdiff_t kGateChannels = kGroupRows / 2;

/// Place of a channel's filter row in its group; its gate row follows two places later.
constexpr std::ptrdiff_t filter_row(std::ptrdiff_t channel_in_group) {
  return channel_in_group / 2 * 4 + channel_in_group % 2;
}
inline constexpr std::ptrdiff_t kGateRowAfter = 2;

/// In segmented order a plane is cut into this many equal segments, and samples at the same place
/// in each of them lie side by side. A multiple of the lanes of every instruction set.
inline constexpr std::ptrdiff_t kSegments = 16;

constexpr std::ptrdiff_t round_up(std::ptrdiff_t value, std::ptrdiff_t step) {
  return (value + step - 1) / step * step;
}

}  // namespace earpoint::kernels
