#include "trunk_kernels.h"

#include <algorithm>

// Compiled once per instruction set; the best one that the processor has is chosen at run time.
// The order of these matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gtf/trunk_kernels.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace earpoint::training::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, 16>;
using Vector = hn::Vec<Lanes>;

HWY_INLINE std::ptrdiff_t lanes() { return static_cast<std::ptrdiff_t>(hn::Lanes(Lanes())); }

HWY_INLINE Vector sigmoid(Vector x) {
  const Lanes d;
  const Vector one = hn::Set(d, 1.0F);
  // The result vanishes beyond 80, and e^x stays finite.
  return hn::Div(one, hn::Add(one, hn::Exp(d, hn::Min(hn::Neg(x), hn::Set(d, 80.0F)))));
}

/// The slope of silu.
HWY_INLINE Vector silu_slope(Vector x) {
  const Lanes d;
  const Vector s = sigmoid(x);
  return hn::Mul(s, hn::MulAdd(x, hn::Sub(hn::Set(d, 1.0F), s), hn::Set(d, 1.0F)));
}

HWY_INLINE float total(Vector v) {
  const Lanes d;
  return hn::GetLane(hn::SumOfLanes(d, v));
}

void silu_rows(const Rows& rows, const float* x, float* to, std::ptrdiff_t to_row) {
  const Lanes d;
  for (std::ptrdiff_t c = 0; c < rows.channels; ++c) {
    for (std::ptrdiff_t t = 0; t < rows.row; t += lanes()) {
      const Vector value = hn::LoadU(d, x + c * rows.row + t);
      hn::StoreU(hn::Mul(value, sigmoid(value)), d, to + c * to_row + t);
    }
  }
}

void silu_rows_back(const Rows& rows, const float* x, float* gradient) {
  const Lanes d;
  for (std::ptrdiff_t i = 0; i < rows.channels * rows.row; i += lanes()) {
    const Vector slope = silu_slope(hn::LoadU(d, x + i));
    hn::StoreU(hn::Mul(slope, hn::LoadU(d, gradient + i)), d, gradient + i);
  }
}

void modulated_rows(const Rows& rows, const float* y, const float* scale, const float* shift,
                    const float* from, float* to, std::ptrdiff_t outer_row) {
  const Lanes d;
  for (std::ptrdiff_t c = 0; c < rows.channels; ++c) {
    const Vector factor = hn::Set(d, 1.0F + scale[c]);
    const Vector offset = hn::Set(d, shift[c]);
    for (std::ptrdiff_t t = 0; t < rows.row; t += lanes()) {
      const Vector u = hn::MulAdd(hn::LoadU(d, y + c * rows.row + t), factor, offset);
      hn::StoreU(hn::MulAdd(u, sigmoid(u), hn::LoadU(d, from + c * outer_row + t)), d,
                 to + c * outer_row + t);
    }
  }
}

void modulated_rows_back(const Rows& rows, const float* y, const float* scale, const float* shift,
                         const float* gradient, float* by_y, std::ptrdiff_t by_y_row,
                         float* by_scale, float* by_shift) {
  const Lanes d;
  for (std::ptrdiff_t c = 0; c < rows.channels; ++c) {
    const Vector factor = hn::Set(d, 1.0F + scale[c]);
    const Vector offset = hn::Set(d, shift[c]);
    Vector scale_sum = hn::Zero(d);
    Vector shift_sum = hn::Zero(d);
    for (std::ptrdiff_t t = 0; t < rows.row; t += lanes()) {
      const Vector value = hn::LoadU(d, y + c * rows.row + t);
      const Vector by_u = hn::Mul(silu_slope(hn::MulAdd(value, factor, offset)),
                                  hn::LoadU(d, gradient + c * rows.row + t));
      scale_sum = hn::MulAdd(by_u, value, scale_sum);
      shift_sum = hn::Add(by_u, shift_sum);
      hn::StoreU(hn::Mul(by_u, factor), d, by_y + c * by_y_row + t);
    }
    by_scale[c] = total(scale_sum);
    by_shift[c] = total(shift_sum);
  }
}

void row_sums(const Rows& rows, const float* x, std::ptrdiff_t x_row, float* sums) {
  const Lanes d;
  for (std::ptrdiff_t c = 0; c < rows.channels; ++c) {
    Vector sum = hn::Zero(d);
    for (std::ptrdiff_t t = 0; t < rows.row; t += lanes()) {
      sum = hn::Add(sum, hn::LoadU(d, x + c * x_row + t));
    }
    sums[c] += total(sum);
  }
}

}  // namespace
}  // namespace earpoint::training::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace earpoint::training {

HWY_EXPORT(silu_rows);
HWY_EXPORT(silu_rows_back);
HWY_EXPORT(modulated_rows);
HWY_EXPORT(modulated_rows_back);
HWY_EXPORT(row_sums);

void silu(const Rows& rows, const float* x, float* to, std::ptrdiff_t to_row) {
  HWY_DYNAMIC_DISPATCH(silu_rows)(rows, x, to, to_row);
}

void silu_back(const Rows& rows, const float* x, float* gradient) {
  HWY_DYNAMIC_DISPATCH(silu_rows_back)(rows, x, gradient);
}

void modulate(const Rows& rows, const float* y, const float* scale, const float* shift,
              const float* from, float* to, std::ptrdiff_t outer_row) {
  HWY_DYNAMIC_DISPATCH(modulated_rows)(rows, y, scale, shift, from, to, outer_row);
}

void modulate_back(const Rows& rows, const float* y, const float* scale, const float* shift,
                   const float* gradient, float* by_y, std::ptrdiff_t by_y_row, float* by_scale,
                   float* by_shift) {
  HWY_DYNAMIC_DISPATCH(modulated_rows_back)
  (rows, y, scale, shift, gradient, by_y, by_y_row, by_scale, by_shift);
}

void add_row_sums(const Rows& rows, const float* x, std::ptrdiff_t x_row, float* sums) {
  HWY_DYNAMIC_DISPATCH(row_sums)(rows, x, x_row, sums);
}

void transpose(const float* from, std::ptrdiff_t from_row, std::ptrdiff_t rows,
               std::ptrdiff_t columns, float* to, std::ptrdiff_t to_row) {
  constexpr std::ptrdiff_t kTile = 16;
  for (std::ptrdiff_t i = 0; i < rows; i += kTile) {
    for (std::ptrdiff_t j = 0; j < columns; j += kTile) {
      for (std::ptrdiff_t r = i; r < std::min(rows, i + kTile); ++r) {
        for (std::ptrdiff_t c = j; c < std::min(columns, j + kTile); ++c) {
          to[c * to_row + r] = from[r * from_row + c];
        }
      }
    }
  }
}

}  // namespace earpoint::training
#endif  // HWY_ONCE
