#pragma once

#include <cstddef>

namespace earpoint::training {

/// Channels of one clip, [channels][row], one after the other. Rows are multiples of 16.
struct Rows {
  std::ptrdiff_t channels = 0;
  std::ptrdiff_t row = 0;
};

/// silu(x) = x / (1 + e^-x). @param to  [channels][to_row]
void silu(const Rows& rows, const float* x, float* to, std::ptrdiff_t to_row);

/// Gradient by x; in place. @param gradient  by silu(x)
void silu_back(const Rows& rows, const float* x, float* gradient);

/// to = from + silu(y * (1 + scale) + shift), with one scale and one shift for a channel.
/// @param from, to  [channels][outer_row]
void modulate(const Rows& rows, const float* y, const float* scale, const float* shift,
              const float* from, float* to, std::ptrdiff_t outer_row);

/// Gradient of modulate() by y, scale and shift.
/// @param gradient  by `to`, [channels][row]
/// @param by_y      [channels][by_y_row]
void modulate_back(const Rows& rows, const float* y, const float* scale, const float* shift,
                   const float* gradient, float* by_y, std::ptrdiff_t by_y_row, float* by_scale,
                   float* by_shift);

/// sums[channel] += all of a row.
void add_row_sums(const Rows& rows, const float* x, std::ptrdiff_t x_row, float* sums);

/// to[column][row] = from[row][column]
void transpose(const float* from, std::ptrdiff_t from_row, std::ptrdiff_t rows,
               std::ptrdiff_t columns, float* to, std::ptrdiff_t to_row);

}  // namespace earpoint::training
