// Products of small matrices that lie in memory row by row. Included once per instruction set.

#if defined(EARPOINT_TRAIN_MULTIPLY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef EARPOINT_TRAIN_MULTIPLY_INL_H_
#undef EARPOINT_TRAIN_MULTIPLY_INL_H_
#else
#define EARPOINT_TRAIN_MULTIPLY_INL_H_
#endif

#include "stack_kernels.h"

#include <algorithm>
#include <cstddef>
#include <span>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace earpoint::training::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::ScalableTag<float>;
using Vector = hn::Vec<Lanes>;
inline constexpr std::ptrdiff_t kLanes = hn::MaxLanes(Lanes());
static_assert(kChannelStep % kLanes == 0);

// As many sums as registers hold beside the operands.
inline constexpr bool kManyRegisters = HWY_CAP_GE512 || HWY_TARGET == HWY_NEON;
inline constexpr std::ptrdiff_t kMostVectors =
    std::min<std::ptrdiff_t>(kManyRegisters ? 4 : 2, kChannelStep / kLanes * 4);

/// Rows of sums that are kept in registers beside `vectors` columns of vectors.
constexpr std::ptrdiff_t rows_for(std::ptrdiff_t vectors) {
  if (!kManyRegisters) return vectors == 1 ? 8 : 4;
  return vectors == 4 ? 6 : 8;
}

/// sums[row][column] += sum over k of a[row][k] * b[k][column] for kRows rows and kVectors vectors
/// of columns. `a_row` and `a_depth` are the steps between the elements of a; one of them is 1.
template <std::ptrdiff_t kRows, std::ptrdiff_t kVectors>
HWY_INLINE void multiply_into(const float* HWY_RESTRICT a, std::ptrdiff_t a_row,
                              std::ptrdiff_t a_depth, std::ptrdiff_t depth,
                              const float* HWY_RESTRICT b, std::ptrdiff_t b_row, Vector* sums) {
  const Lanes d;
  for (std::ptrdiff_t k = 0; k < depth; ++k) {
    Vector columns[kVectors];
    HWY_UNROLL(4)
    for (std::ptrdiff_t v = 0; v < kVectors; ++v) columns[v] = hn::LoadU(d, b + v * kLanes);
    HWY_UNROLL(8)
    for (std::ptrdiff_t r = 0; r < kRows; ++r) {
      const Vector factor = hn::Set(d, a[r * a_row]);
      HWY_UNROLL(4)
      for (std::ptrdiff_t v = 0; v < kVectors; ++v) {
        sums[r * kVectors + v] = hn::MulAdd(factor, columns[v], sums[r * kVectors + v]);
      }
    }
    a += a_depth;
    b += b_row;
  }
}

/// Calls work(sums) with the block of `to` in registers, and puts it back.
template <std::ptrdiff_t kRows, std::ptrdiff_t kVectors, class Work>
HWY_INLINE void with_sums(float* HWY_RESTRICT to, std::ptrdiff_t to_row, const Work& work) {
  const Lanes d;
  Vector sums[kRows * kVectors];
  HWY_UNROLL(8)
  for (std::ptrdiff_t r = 0; r < kRows; ++r) {
    HWY_UNROLL(4)
    for (std::ptrdiff_t v = 0; v < kVectors; ++v) {
      sums[r * kVectors + v] = hn::LoadU(d, to + r * to_row + v * kLanes);
    }
  }
  work(sums);
  HWY_UNROLL(8)
  for (std::ptrdiff_t r = 0; r < kRows; ++r) {
    HWY_UNROLL(4)
    for (std::ptrdiff_t v = 0; v < kVectors; ++v) {
      hn::StoreU(sums[r * kVectors + v], d, to + r * to_row + v * kLanes);
    }
  }
}

template <std::ptrdiff_t kRows, std::ptrdiff_t kVectors>
HWY_NOINLINE void product_block(std::span<const Product> products, std::ptrdiff_t row,
                                std::ptrdiff_t column, float* HWY_RESTRICT to,
                                std::ptrdiff_t to_row) {
  with_sums<kRows, kVectors>(to + row * to_row + column, to_row, [=](Vector* sums) HWY_ATTR {
    for (const Product& p : products) {
      multiply_into<kRows, kVectors>(p.a + row * p.a_row, p.a_row, 1, p.depth, p.b + column,
                                     p.b_row, sums);
    }
  });
}

/// All rows of kVectors vectors of columns.
template <std::ptrdiff_t kVectors>
HWY_INLINE void product_columns(std::span<const Product> products, std::ptrdiff_t rows,
                                std::ptrdiff_t column, float* HWY_RESTRICT to,
                                std::ptrdiff_t to_row) {
  constexpr std::ptrdiff_t kRows = rows_for(kVectors);
  std::ptrdiff_t row = 0;
  for (; row + kRows <= rows; row += kRows) {
    product_block<kRows, kVectors>(products, row, column, to, to_row);
  }
  for (; row < rows; ++row) product_block<1, kVectors>(products, row, column, to, to_row);
}

/// Calls work(column, vectors) with a constant number of vectors for all columns.
template <class Work>
HWY_INLINE void for_column_blocks(std::ptrdiff_t columns, const Work& work) {
  using Count = std::ptrdiff_t;
  Count column = 0;
  for (; column + kMostVectors * kLanes <= columns; column += kMostVectors * kLanes) {
    work(column, std::integral_constant<Count, kMostVectors>());
  }
  const Count rest = (columns - column) / kLanes;
  if constexpr (kMostVectors > 3) {
    if (rest == 3) return work(column, std::integral_constant<Count, 3>());
  }
  if constexpr (kMostVectors > 2) {
    if (rest == 2) return work(column, std::integral_constant<Count, 2>());
  }
  if (rest == 1) work(column, std::integral_constant<Count, 1>());
}

/// See add_outer_products(). Rows that divide kChannelStep.
template <std::ptrdiff_t kVectors>
HWY_NOINLINE void outer_columns(const Outer& outer, std::ptrdiff_t column) {
  constexpr std::ptrdiff_t kRows = kVectors > 2 || !kManyRegisters ? 4 : 8;
  static_assert(kChannelStep % kRows == 0);
  for (std::ptrdiff_t row = 0; row < outer.rows; row += kRows) {
    with_sums<kRows, kVectors>(
        outer.to + row * outer.columns + column, outer.columns, [=](Vector* sums) HWY_ATTR {
          multiply_into<kRows, kVectors>(outer.a + row, 1, outer.a_row, outer.count,
                                         outer.b + column, outer.b_row, sums);
        });
  }
}

}  // namespace earpoint::training::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
