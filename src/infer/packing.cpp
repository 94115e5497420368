#include "packing.h"

#include "gate_scale.h"
#include "tile_shape.h"

#include <array>
#include <cstddef>

#include <earpoint/core/error.h>

namespace earpoint::infer {

AlignedFloats pack_rows(std::span<const float> matrix, int rows, int columns, double scale) {
  EARPOINT_CHECK(std::ssize(matrix) == static_cast<std::ptrdiff_t>(rows) * columns);
  AlignedFloats packed(static_cast<std::size_t>(round_up(rows, kGroupRows)) * columns);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const std::ptrdiff_t group = row / kGroupRows;
      packed.data()[(group * columns + column) * kGroupRows + row % kGroupRows] =
          static_cast<float>(scale * matrix[static_cast<std::size_t>(row) * columns + column]);
    }
  }
  return packed;
}

AlignedFloats pack_vector(std::span<const float> vector, double scale) {
  return pack_rows(vector, static_cast<int>(vector.size()), 1, scale);
}

AlignedFloats pack_gate(Scheme scheme, std::span<const float> filter, std::span<const float> gate,
                        int channels, int taps) {
  EARPOINT_CHECK(scheme == Scheme::taps || taps == 3);
  EARPOINT_CHECK(std::ssize(filter) == static_cast<std::ptrdiff_t>(channels) * channels * taps);
  EARPOINT_CHECK(gate.size() == filter.size());
  const int positions = scheme == Scheme::taps ? taps : shape_of(scheme).positions;
  const int groups = round_up(channels, kGateChannels) / kGateChannels;
  AlignedFloats packed(static_cast<std::size_t>(groups) * positions * channels * kGroupRows);

  const auto pack_row = [&](const float* row, std::ptrdiff_t group, int packed_row, double scale) {
    for (int channel = 0; channel < channels; ++channel) {
      const float* of_channel = row + static_cast<std::ptrdiff_t>(channel) * taps;
      std::array<double, kMostPositions> factors{};
      if (scheme != Scheme::taps) {
        const std::array<double, 3> three = {of_channel[0], of_channel[1], of_channel[2]};
        factors = factors_of_taps(scheme, three);
      }
      for (int p = 0; p < positions; ++p) {
        const double factor = scheme == Scheme::taps ? of_channel[p] : factors[p];
        const std::ptrdiff_t depth = (group * positions + p) * channels + channel;
        packed.data()[depth * kGroupRows + packed_row] = static_cast<float>(scale * factor);
      }
    }
  };
  for (int channel = 0; channel < channels; ++channel) {
    const std::ptrdiff_t from = static_cast<std::ptrdiff_t>(channel) * channels * taps;
    const int group = channel / kGateChannels;
    const int row = filter_row(channel % kGateChannels);
    pack_row(filter.data() + from, group, row, kFilterScale);
    pack_row(gate.data() + from, group, row + kGateRowAfter, kGateScale);
  }
  return packed;
}

}  // namespace earpoint::infer
