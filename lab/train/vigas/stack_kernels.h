#pragma once

#include <cstddef>
#include <span>

namespace earpoint::training {

/// Channels lie side by side, sample after sample, and their number is a multiple of this: whole
/// vectors of every instruction set.
inline constexpr std::ptrdiff_t kChannelStep = 16;

/// a [rows][depth] times b [depth][columns]; a_row and b_row are the steps from row to row.
struct Product {
  const float* a = nullptr;
  std::ptrdiff_t a_row = 0;
  std::ptrdiff_t depth = 0;
  const float* b = nullptr;
  std::ptrdiff_t b_row = 0;
};

/// to[row][column] += all products.
/// @param to_row   step from row to row
/// @param columns  a multiple of kChannelStep
void add_products(std::span<const Product> products, float* to, std::ptrdiff_t to_row,
                  std::ptrdiff_t rows, std::ptrdiff_t columns);

/// What add_outer_products() multiplies: in the gradient of a Product by b.
struct Outer {
  const float* a = nullptr;  ///< [count][rows]
  std::ptrdiff_t a_row = 0;
  const float* b = nullptr;  ///< [count][columns]
  std::ptrdiff_t b_row = 0;
  std::ptrdiff_t count = 0;
  std::ptrdiff_t rows = 0;     ///< a multiple of kChannelStep
  std::ptrdiff_t columns = 0;  ///< a multiple of kChannelStep
  float* to = nullptr;         ///< [rows][columns]
};

/// to[row][column] += sum over i < count of a[i][row] * b[i][column].
void add_outer_products(const Outer& outer);

/// Every row of `to` becomes `factor` times that of `from`, plus `bias`.
/// @param from, to  [rows][columns] with the same step; may be the same
void scale_rows(const float* from, float factor, const float* bias, float* to, std::ptrdiff_t row,
                std::ptrdiff_t rows, std::ptrdiff_t columns);

/// sums[column] += all rows of `from`.
void add_rows(const float* from, std::ptrdiff_t row, std::ptrdiff_t rows, std::ptrdiff_t columns,
              float* sums);

/// The gates of some samples: [samples][2 channels], filter first.
///
/// Before: what the convolutions give, f and g. After: tanh(f) and sigmoid(g).
/// @param gated  [samples][channels], receives sin(tanh(f) * sigmoid(g))
void open_gates(float* gates, float* gated, std::ptrdiff_t samples, std::ptrdiff_t channels);

/// The gradient by f and g of what open_gates() computed.
/// @param gates     tanh(f) and sigmoid(g)
/// @param gradient  by the gated channels, [samples][channels]; replaced by these channels
/// @param by_gates  receives the gradient, shape of gates
/// @param sums      [2 channels], receives its sum over the samples in addition
void open_gates_back(const float* gates, float* gradient, float* by_gates, float* sums,
                     std::ptrdiff_t samples, std::ptrdiff_t channels);

/// sin(x), in place. @param count  a multiple of kChannelStep
void sines(float* x, std::ptrdiff_t count);

/// gradient *= cos(x), then x = sin(x). @param count  a multiple of kChannelStep
void sines_back(float* x, float* gradient, std::ptrdiff_t count);

}  // namespace earpoint::training
