#include "packing.h"

#include "gate_scale.h"

#include <array>
#include <cstddef>

#include <earpoint/error.h>
#include <earpoint/kernels/tile_shape.h>

namespace earpoint::kernels {

AlignedFloats pack_rows(std::span<const float> matrix, std::ptrdiff_t rows, std::ptrdiff_t columns,
                        double scale) {
  EARPOINT_CHECK(std::ssize(matrix) == rows * columns);
  AlignedFloats packed(round_up(rows, kGroupRows) * columns);
  for (std::ptrdiff_t row = 0; row < rows; ++row) {
    for (std::ptrdiff_t column = 0; column < columns; ++column) {
      const std::ptrdiff_t group = row / kGroupRows;
      packed.data()[(group * columns + column) * kGroupRows + row % kGroupRows] =
          static_cast<float>(scale * matrix[row * columns + column]);
    }
  }
  return packed;
}

AlignedFloats pack_vector(std::span<const float> vector, double scale) {
  return pack_rows(vector, std::ssize(vector), 1, scale);
}

AlignedFloats pack_gate(Scheme scheme, std::span<const float> filter, std::span<const float> gate,
                        std::ptrdiff_t channels, std::ptrdiff_t taps) {
  EARPOINT_CHECK(scheme == Scheme::taps || taps == 3);
  EARPOINT_CHECK(std::ssize(filter) == channels * channels * taps);
  EARPOINT_CHECK(gate.size() == filter.size());
  const std::ptrdiff_t positions = scheme == Scheme::taps ? taps : shape_of(scheme).positions;
  const std::ptrdiff_t groups = round_up(channels, kGateChannels) / kGateChannels;
  AlignedFloats packed(groups * positions * channels * kGroupRows);

  const auto pack_row = [&](std::span<const float> row, std::ptrdiff_t group,
                            std::ptrdiff_t packed_row, double scale) {
    for (std::ptrdiff_t channel = 0; channel < channels; ++channel) {
      const std::span<const float> of_channel = row.subspan(channel * taps, taps);
      std::array<double, kMostPositions> factors{};
      if (scheme != Scheme::taps) {
        const std::array<double, 3> three = {of_channel[0], of_channel[1], of_channel[2]};
        factors = factors_of_taps(scheme, three);
      }
      for (std::ptrdiff_t p = 0; p < positions; ++p) {
        const double factor = scheme == Scheme::taps ? of_channel[p] : factors[p];
        const std::ptrdiff_t depth = (group * positions + p) * channels + channel;
        packed.data()[depth * kGroupRows + packed_row] = static_cast<float>(scale * factor);
      }
    }
  };
  for (std::ptrdiff_t channel = 0; channel < channels; ++channel) {
    const std::ptrdiff_t from = channel * channels * taps;
    const std::ptrdiff_t group = channel / kGateChannels;
    const std::ptrdiff_t row = filter_row(channel % kGateChannels);
    pack_row(filter.subspan(from, channels * taps), group, row, kFilterScale);
    pack_row(gate.subspan(from, channels * taps), group, row + kGateRowAfter, kGateScale);
  }
  return packed;
}

}  // namespace earpoint::kernels
