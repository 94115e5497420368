#include <earpoint/kernels/tile_kernels.h>

#include <span>

// Compiled once per instruction set; the best one that the processor has is chosen at run time.
// The order of these matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tile_kernels.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>

#include "layer-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace earpoint::kernels::HWY_NAMESPACE {

void layer_tile(const LayerPass& pass, const Sweep& sweep, std::ptrdiff_t tile,
                const TileScratch& scratch) {
  switch (sweep.scheme) {
    case Scheme::taps:
      return run_tile<Scheme::taps>(pass, sweep, tile, scratch);
    case Scheme::four:
      return run_tile<Scheme::four>(pass, sweep, tile, scratch);
    case Scheme::three:
      return run_tile<Scheme::three>(pass, sweep, tile, scratch);
    case Scheme::two:
      return run_tile<Scheme::two>(pass, sweep, tile, scratch);
  }
}

void input_channel(const InputPass& pass, std::ptrdiff_t channel) {
  const Lanes d;
  const float* weights = pass.weights + channel * pass.audio_channels;
  float* x = pass.x + channel * pass.stride;
  // The stride has room for a whole vector behind the last place.
  const PlaneOrder& order = pass.order;
  for (std::ptrdiff_t place = 0; place < order.places(); place += kLanes) {
    Vector sum = hn::Set(d, pass.bias[channel]);
    for (std::ptrdiff_t audio = 0; audio < pass.audio_channels; ++audio) {
      sum = hn::MulAdd(hn::Set(d, weights[audio]),
                       hn::LoadU(d, pass.source + audio * pass.stride + place), sum);
    }
    hn::StoreU(sum, d, x + place);
  }
  for (std::ptrdiff_t t = order.samples; t < order.places(); ++t) x[order.place_of(t)] = 0.0F;
}

void output_tile(const OutputPass& pass, std::ptrdiff_t tile, const TileScratch& scratch) {
  const Lanes d;
  const std::ptrdiff_t groups = (pass.channels + kGroupRows - 1) / kGroupRows;
  const std::ptrdiff_t first_sample = tile * kTileColumns;
  for (std::ptrdiff_t channel = 0; channel < pass.channels; ++channel) {
    for (std::ptrdiff_t v = 0; v < kTileVectors; ++v) {
      hn::Store(hn::LoadU(d, pass.skip + channel * pass.stride + first_sample + v * kLanes), d,
                scratch.panel + channel * kTileColumns + v * kLanes);
    }
  }
  for (std::ptrdiff_t group = 0; group < groups; ++group) {
    multiply_group(pass.first_weights + group * kGroupRows * pass.channels, scratch.panel,
                   pass.channels, scratch.products);
    for (std::ptrdiff_t r = 0; r < kGroupRows; ++r) {
      const Vector bias = hn::Set(d, pass.first_bias[group * kGroupRows + r]);
      float* out = scratch.gated + (group * kGroupRows + r) * kTileColumns;
      for (std::ptrdiff_t v = 0; v < kTileVectors; ++v) {
        const Vector sum =
            hn::Add(hn::Load(d, scratch.products + r * kTileColumns + v * kLanes), bias);
        hn::Store(hn::Sin(d, sum), d, out + v * kLanes);
      }
    }
  }
  const std::ptrdiff_t samples = std::min(kTileColumns, pass.samples - first_sample);
  for (std::ptrdiff_t first = 0; first < pass.audio_channels; first += kGroupRows) {
    multiply_group(pass.second_weights + first * pass.channels, scratch.gated, pass.channels,
                   scratch.products);
    for (std::ptrdiff_t r = 0; r < std::min(kGroupRows, pass.audio_channels - first); ++r) {
      float* out = pass.output + (first + r) * pass.samples + first_sample;
      const float bias = pass.second_bias[first + r];
      for (std::ptrdiff_t i = 0; i < samples; ++i)
        out[i] = scratch.products[r * kTileColumns + i] + bias;
    }
  }
}

/// Turns a block of 4 rows of 4 numbers on its diagonal.
HWY_INLINE void transpose_block(const float* from, std::ptrdiff_t from_stride, float* to,
                                std::ptrdiff_t to_stride, bool add) {
#if HWY_TARGET == HWY_SCALAR
  for (std::ptrdiff_t row = 0; row < 4; ++row) {
    for (std::ptrdiff_t column = 0; column < 4; ++column) {
      float& out = to[column * to_stride + row];
      out = (add ? out : 0.0F) + from[row * from_stride + column];
    }
  }
#else
  const hn::FixedTag<float, 4> d;
  using Quad = hn::Vec<decltype(d)>;
  const Quad row0 = hn::LoadU(d, from);
  const Quad row1 = hn::LoadU(d, from + from_stride);
  const Quad row2 = hn::LoadU(d, from + 2 * from_stride);
  const Quad row3 = hn::LoadU(d, from + 3 * from_stride);
  const Quad low01 = hn::InterleaveLower(d, row0, row1);
  const Quad low23 = hn::InterleaveLower(d, row2, row3);
  const Quad high01 = hn::InterleaveUpper(d, row0, row1);
  const Quad high23 = hn::InterleaveUpper(d, row2, row3);
  Quad columns[4] = {hn::ConcatLowerLower(d, low23, low01), hn::ConcatUpperUpper(d, low23, low01),
                     hn::ConcatLowerLower(d, high23, high01),
                     hn::ConcatUpperUpper(d, high23, high01)};
  HWY_UNROLL(4)
  for (std::ptrdiff_t i = 0; i < 4; ++i) {
    if (add) columns[i] = hn::Add(columns[i], hn::LoadU(d, to + i * to_stride));
    hn::StoreU(columns[i], d, to + i * to_stride);
  }
#endif
}

void to_segments(const PlaneOrder& order, const float* in_time, float* in_segments) {
  const std::ptrdiff_t segment = order.segment;
  std::ptrdiff_t first = 0;
  for (; first + 4 <= segment; first += 4) {
    for (std::ptrdiff_t s = 0; s < kSegments; s += 4) {
      transpose_block(in_time + s * segment + first, segment, in_segments + first * kSegments + s,
                      kSegments, false);
    }
  }
  for (; first < segment; ++first) {
    for (std::ptrdiff_t s = 0; s < kSegments; ++s) {
      in_segments[first * kSegments + s] = in_time[s * segment + first];
    }
  }
  for (std::ptrdiff_t t = order.samples; t < order.places(); ++t) {
    in_segments[order.place_of(t)] = 0.0F;
  }
}

void to_time(const PlaneOrder& order, const float* in_segments, float* in_time, bool add) {
  const std::ptrdiff_t segment = order.segment;
  std::ptrdiff_t first = 0;
  for (; first + 4 <= segment; first += 4) {
    for (std::ptrdiff_t s = 0; s < kSegments; s += 4) {
      transpose_block(in_segments + first * kSegments + s, kSegments, in_time + s * segment + first,
                      segment, add);
    }
  }
  for (; first < segment; ++first) {
    for (std::ptrdiff_t s = 0; s < kSegments; ++s) {
      float& out = in_time[s * segment + first];
      out = (add ? out : 0.0F) + in_segments[first * kSegments + s];
    }
  }
}

}  // namespace earpoint::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace earpoint::kernels {

HWY_EXPORT(layer_tile);
HWY_EXPORT(input_channel);
HWY_EXPORT(output_tile);
HWY_EXPORT(to_segments);
HWY_EXPORT(to_time);

void run_layer_tile(const LayerPass& pass, const Sweep& sweep, std::ptrdiff_t tile,
                    const TileScratch& scratch) {
  HWY_DYNAMIC_DISPATCH(layer_tile)(pass, sweep, tile, scratch);
}

void run_input_channel(const InputPass& pass, std::ptrdiff_t channel) {
  HWY_DYNAMIC_DISPATCH(input_channel)(pass, channel);
}

void run_output_tile(const OutputPass& pass, std::ptrdiff_t tile, const TileScratch& scratch) {
  HWY_DYNAMIC_DISPATCH(output_tile)(pass, tile, scratch);
}

void order_in_segments(const PlaneOrder& segmented, const float* in_time, float* in_segments) {
  HWY_DYNAMIC_DISPATCH(to_segments)(segmented, in_time, in_segments);
}

void order_in_time(const PlaneOrder& segmented, const float* in_segments, float* in_time,
                   bool add) {
  HWY_DYNAMIC_DISPATCH(to_time)(segmented, in_segments, in_time, add);
}

}  // namespace earpoint::kernels
#endif  // HWY_ONCE
