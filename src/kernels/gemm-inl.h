// The inner product of packed weights and a panel. Included once per instruction set.

#if defined(EARPOINT_KERNELS_GEMM_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef EARPOINT_KERNELS_GEMM_INL_H_
#undef EARPOINT_KERNELS_GEMM_INL_H_
#else
#define EARPOINT_KERNELS_GEMM_INL_H_
#endif

#include <hwy/highway.h>

#include <earpoint/kernels/tile_shape.h>

HWY_BEFORE_NAMESPACE();
namespace earpoint::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::ScalableTag<float>;
using Vector = hn::Vec<Lanes>;
inline constexpr std::ptrdiff_t kLanes = hn::MaxLanes(Lanes());
inline constexpr std::ptrdiff_t kTileVectors = kTileColumns / kLanes;
static_assert(kTileColumns % kLanes == 0);

// As many sums as registers hold beside the operands: 16 of 32, or 8 of 16.
inline constexpr bool kManyRegisters = HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_NEON;
inline constexpr std::ptrdiff_t kSumRows = kManyRegisters ? kGroupRows : kGroupRows / 2;
inline constexpr std::ptrdiff_t kSumVectors = kLanes == 1 ? 1 : 2;
static_assert(kGroupRows % kSumRows == 0 && kTileVectors % kSumVectors == 0);

/// kSumRows rows and kSumVectors vectors of multiply_group(), their sums kept in registers.
HWY_INLINE void multiply_block(const float* HWY_RESTRICT weights, const float* HWY_RESTRICT panel,
                               std::ptrdiff_t depth, float* HWY_RESTRICT products) {
  const Lanes d;
  Vector sums[kSumRows * kSumVectors];
  HWY_UNROLL(16)
  for (std::ptrdiff_t i = 0; i < kSumRows * kSumVectors; ++i) sums[i] = hn::Zero(d);

  for (std::ptrdiff_t k = 0; k < depth; ++k) {
    Vector columns[kSumVectors];
    HWY_UNROLL(2)
    for (std::ptrdiff_t v = 0; v < kSumVectors; ++v) columns[v] = hn::Load(d, panel + v * kLanes);
    HWY_UNROLL(8)
    for (std::ptrdiff_t r = 0; r < kSumRows; ++r) {
      const Vector weight = hn::Set(d, weights[r]);
      HWY_UNROLL(2)
      for (std::ptrdiff_t v = 0; v < kSumVectors; ++v) {
        sums[r * kSumVectors + v] = hn::MulAdd(weight, columns[v], sums[r * kSumVectors + v]);
      }
    }
    weights += kGroupRows;
    panel += kTileColumns;
  }

  HWY_UNROLL(8)
  for (std::ptrdiff_t r = 0; r < kSumRows; ++r) {
    HWY_UNROLL(2)
    for (std::ptrdiff_t v = 0; v < kSumVectors; ++v) {
      hn::Store(sums[r * kSumVectors + v], d, products + r * kTileColumns + v * kLanes);
    }
  }
}

/// products[row][column] = sum over k of weights[k][row] * panel[k][column].
///
/// @param weights   packed, shape [depth][kGroupRows]
/// @param panel     shape [depth][kTileColumns], aligned
/// @param products  shape [kGroupRows][kTileColumns], aligned
HWY_INLINE void multiply_group(const float* HWY_RESTRICT weights, const float* HWY_RESTRICT panel,
                               std::ptrdiff_t depth, float* HWY_RESTRICT products) {
  for (std::ptrdiff_t column = 0; column < kTileColumns; column += kSumVectors * kLanes) {
    for (std::ptrdiff_t row = 0; row < kGroupRows; row += kSumRows) {
      multiply_block(weights + row, panel + column, depth, products + row * kTileColumns + column);
    }
  }
}

}  // namespace earpoint::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
