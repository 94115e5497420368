#include <earpoint/kernels/frame_product.h>

#include <algorithm>

#include <earpoint/error.h>

// Compiled once per instruction set; the best one that the processor has is chosen at run time.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "frame_product.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace earpoint::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// kFrames rows of one chunk, their sums kept in registers.
template <int kFrames>
HWY_INLINE void multiply_chunk(const float* HWY_RESTRICT weights, std::ptrdiff_t inputs,
                               const float* HWY_RESTRICT in, std::ptrdiff_t in_stride,
                               const float* HWY_RESTRICT bias, float* HWY_RESTRICT out,
                               std::ptrdiff_t out_stride, bool add) {
  const hn::CappedTag<float, 8> d;
  constexpr std::ptrdiff_t kLanes = hn::MaxLanes(hn::CappedTag<float, 8>());
  constexpr std::ptrdiff_t kStep = kChunk / kLanes > 1 ? 2 * kLanes : kLanes;
  for (std::ptrdiff_t column = 0; column < kChunk; column += kStep) {
    hn::Vec<hn::CappedTag<float, 8>> low[kFrames];
    hn::Vec<hn::CappedTag<float, 8>> high[kFrames];
    HWY_UNROLL(4)
    for (int f = 0; f < kFrames; ++f) {
      const float* start = (add ? out + f * out_stride : bias) + column;
      low[f] = hn::LoadU(d, start);
      high[f] = hn::LoadU(d, start + kLanes);
    }
    const float* row = weights + column;
    for (std::ptrdiff_t k = 0; k < inputs; ++k) {
      const auto weight_low = hn::LoadU(d, row);
      const auto weight_high = hn::LoadU(d, row + kLanes);
      HWY_UNROLL(4)
      for (int f = 0; f < kFrames; ++f) {
        const auto x = hn::Set(d, in[f * in_stride + k]);
        low[f] = hn::MulAdd(weight_low, x, low[f]);
        high[f] = hn::MulAdd(weight_high, x, high[f]);
      }
      row += kChunk;
    }
    HWY_UNROLL(4)
    for (int f = 0; f < kFrames; ++f) {
      hn::StoreU(low[f], d, out + f * out_stride + column);
      hn::StoreU(high[f], d, out + f * out_stride + column + kLanes);
    }
  }
}

void multiply_frames(const float* weights, std::ptrdiff_t inputs, std::ptrdiff_t row,
                     const float* in, std::ptrdiff_t in_stride, std::ptrdiff_t frames,
                     const float* bias, float* out, bool add) {
  constexpr int kTogether = 4;
  for (std::ptrdiff_t chunk = 0; chunk < row; chunk += kChunk) {
    const float* of_chunk = weights + chunk * inputs;
    std::ptrdiff_t f = 0;
    for (; f + kTogether <= frames; f += kTogether) {
      multiply_chunk<kTogether>(of_chunk, inputs, in + f * in_stride, in_stride, bias + chunk,
                                out + f * row + chunk, row, add);
    }
    for (; f < frames; ++f) {
      multiply_chunk<1>(of_chunk, inputs, in + f * in_stride, in_stride, bias + chunk,
                        out + f * row + chunk, row, add);
    }
  }
}

}  // namespace earpoint::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace earpoint::kernels {
namespace {

HWY_EXPORT(multiply_frames);

std::ptrdiff_t whole_chunks(std::ptrdiff_t count) { return (count + kChunk - 1) / kChunk * kChunk; }

}  // namespace

FrameMatrix::FrameMatrix(std::span<const float> matrix, std::ptrdiff_t outputs)
    : inputs_(std::ssize(matrix) / outputs),
      outputs_(outputs),
      packed_(whole_chunks(outputs) * inputs_) {
  EARPOINT_CHECK(inputs_ * outputs_ == std::ssize(matrix));
  for (std::ptrdiff_t out = 0; out < outputs_; ++out) {
    float* chunk = packed_.data() + out / kChunk * kChunk * inputs_ + out % kChunk;
    for (std::ptrdiff_t in = 0; in < inputs_; ++in) {
      chunk[in * kChunk] = matrix[static_cast<std::size_t>(out * inputs_ + in)];
    }
  }
}

std::ptrdiff_t FrameMatrix::row() const { return whole_chunks(outputs_); }

void FrameMatrix::multiply(const float* in, std::ptrdiff_t in_stride, std::ptrdiff_t frames,
                           const float* bias, float* out, bool add) const {
  HWY_DYNAMIC_DISPATCH(multiply_frames)
  (packed_.data(), inputs_, row(), in, in_stride, frames, add ? out : bias, out, add);
}

AlignedFloats padded_row(std::span<const float> values) {
  AlignedFloats row(whole_chunks(std::ssize(values)));
  std::copy(values.begin(), values.end(), row.data());
  return row;
}

}  // namespace earpoint::kernels
#endif
