#pragma once

#include <cstddef>
#include <span>

#include <earpoint/kernels/aligned_floats.h>
#include <earpoint/kernels/lattice.h>

namespace earpoint::kernels {

/// Packs a matrix for multiply_group: [group][columns][kGroupRows], rows past the last are zero.
/// @param matrix  [rows][columns]
/// @param scale   multiplies every element
[[nodiscard]] AlignedFloats pack_rows(std::span<const float> matrix, std::ptrdiff_t rows,
                                      std::ptrdiff_t columns, double scale = 1.0);

/// A vector padded with zeros to whole groups of kGroupRows.
[[nodiscard]] AlignedFloats pack_vector(std::span<const float> vector, double scale = 1.0);

/// Packs the weights of filter and gate, scaled for gated():
/// [group][position][depth][kGroupRows], see filter_row(). For Scheme::taps the depth counts tap by
/// tap the channels of each; a range of taps is then a range of the depth.
/// @param filter  [channels][channels][taps]; `gate` likewise
/// @param taps    3 unless the scheme is Scheme::taps
[[nodiscard]] AlignedFloats pack_gate(Scheme scheme, std::span<const float> filter,
                                      std::span<const float> gate, std::ptrdiff_t channels,
                                      std::ptrdiff_t taps);

}  // namespace earpoint::kernels
