// One tile of one layer of the gated stack. Included once per instruction set.

#if defined(EARPOINT_KERNELS_LAYER_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef EARPOINT_KERNELS_LAYER_INL_H_
#undef EARPOINT_KERNELS_LAYER_INL_H_
#else
#define EARPOINT_KERNELS_LAYER_INL_H_
#endif

#include "columns-inl.h"
#include "gate-inl.h"
#include "gemm-inl.h"
#include "lattice-inl.h"

#include <hwy/highway.h>

#include <earpoint/kernels/tile_kernels.h>

HWY_BEFORE_NAMESPACE();
namespace earpoint::kernels::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Transforms a vector of columns of one channel and puts it into the panel.
template <Scheme kScheme, class Load>
HWY_INLINE void fill_vector(const Load& load, std::ptrdiff_t position_stride,
                            float* HWY_RESTRICT panel) {
  constexpr SchemeShape kShape = shape_of(kScheme);
  const Lanes d;
  Vector inputs[kShape.inputs];
  HWY_UNROLL(6)
  for (std::ptrdiff_t i = 0; i < kShape.inputs; ++i) inputs[i] = load(i);
  Vector products[kShape.positions];
  transform_inputs<kScheme>(d, inputs, products);
  HWY_UNROLL(6)
  for (std::ptrdiff_t p = 0; p < kShape.positions; ++p) {
    hn::Store(products[p], d, panel + p * position_stride);
  }
}

/// Fills the panel: the transformed inputs of every channel.
template <Scheme kScheme>
HWY_INLINE void fill_panel(const LayerPass& pass, const Sweep& sweep, const TileRuns& runs,
                           float* HWY_RESTRICT panel) {
  const Lanes d;
  const std::ptrdiff_t position_stride = pass.channels * kTileColumns;
  const std::ptrdiff_t first_offset = sweep.first_offset;
  const std::ptrdiff_t step = sweep.step;
  const std::ptrdiff_t last_offset = first_offset + (shape_of(kScheme).inputs - 1) * step;
  for (std::ptrdiff_t v = 0; v < kTileVectors; ++v) {
    const bool whole = runs.is_whole(v, first_offset, last_offset, pass.order.places());
    const std::ptrdiff_t first = runs.runs[runs.begin[v]].place + first_offset;
    const std::span<const Run> of_vector = runs.of_vector(v);
    for (std::ptrdiff_t channel = 0; channel < pass.channels; ++channel) {
      const float* plane = pass.x + channel * pass.stride;
      float* to = panel + channel * kTileColumns + v * kLanes;
      if (whole) {
        fill_vector<kScheme>([=](std::ptrdiff_t i)
                                 HWY_ATTR { return hn::LoadU(d, plane + first + i * step); },
                             position_stride, to);
      } else {
        fill_vector<kScheme>(
            [=, &pass](std::ptrdiff_t i) HWY_ATTR {
              return gather_columns(plane, pass.order, of_vector, first_offset + i * step);
            },
            position_stride, to);
      }
    }
  }
}

/// From the products of one group of rows to gated channels, for every output of the scheme.
template <Scheme kScheme>
HWY_INLINE void gate_group(const float* HWY_RESTRICT products, const float* HWY_RESTRICT constants,
                           std::ptrdiff_t output_stride, float* HWY_RESTRICT gated_channels) {
  constexpr SchemeShape kShape = shape_of(kScheme);
  const Lanes d;
  for (std::ptrdiff_t channel = 0; channel < kGateChannels; ++channel) {
    const std::ptrdiff_t row = filter_row(channel);
    for (std::ptrdiff_t v = 0; v < kTileVectors; ++v) {
      Vector filter_products[kShape.positions];
      Vector gate_products[kShape.positions];
      HWY_UNROLL(6)
      for (std::ptrdiff_t p = 0; p < kShape.positions; ++p) {
        const float* at = products + (p * kGroupRows + row) * kTileColumns + v * kLanes;
        filter_products[p] = hn::Load(d, at);
        gate_products[p] = hn::Load(d, at + kGateRowAfter * kTileColumns);
      }
      Vector filter[kShape.outputs];
      Vector gate[kShape.outputs];
      transform_products<kScheme>(d, filter_products, hn::Set(d, constants[row]), filter);
      transform_products<kScheme>(d, gate_products, hn::Set(d, constants[row + kGateRowAfter]),
                                  gate);
      HWY_UNROLL(4)
      for (std::ptrdiff_t q = 0; q < kShape.outputs; ++q) {
        hn::Store(gated(d, filter[q], gate[q]), d,
                  gated_channels + q * output_stride + channel * kTileColumns + v * kLanes);
      }
    }
  }
}

/// Calls whole(place, column) for every vector of columns that lies side by side in the plane, and
/// single(place, column) for every other column in the plane.
template <class Whole, class Single>
HWY_INLINE void for_columns(const TileRuns& runs, std::ptrdiff_t offset, std::ptrdiff_t places,
                            const Whole& whole, const Single& single) {
  for (std::ptrdiff_t v = 0; v < kTileVectors; ++v) {
    for (const Run& run : runs.of_vector(v)) {
      const std::ptrdiff_t place = run.place + offset;
      const std::ptrdiff_t column = v * kLanes + run.lane;
      if (run.length == kLanes && place + kLanes <= places) {
        whole(place, column);
      } else {
        for (std::ptrdiff_t i = 0; i < run.length && place + i < places; ++i)
          single(place + i, column + i);
      }
    }
  }
}

/// next_x = (residual + x) / 2 for one row.
HWY_INLINE void store_residual(const LayerPass& pass, const TileRuns& runs, std::ptrdiff_t offset,
                               std::ptrdiff_t channel, const float* HWY_RESTRICT products) {
  const Lanes d;
  const float bias = pass.residual_bias[channel];
  const float* HWY_RESTRICT x = pass.x + channel * pass.stride;
  float* HWY_RESTRICT next_x = pass.next_x + channel * pass.stride;
  for_columns(
      runs, offset, pass.order.places(),
      [=](std::ptrdiff_t place, std::ptrdiff_t column) HWY_ATTR {
        const Vector sum = hn::Add(hn::Load(d, products + column), hn::Set(d, bias));
        hn::StoreU(hn::MulAdd(hn::Set(d, 0.5F), hn::LoadU(d, x + place), sum), d, next_x + place);
      },
      [=](std::ptrdiff_t place, std::ptrdiff_t column)
          HWY_ATTR { next_x[place] = 0.5F * x[place] + (products[column] + bias); });
}

/// skip += products for one row, or skip = products.
HWY_INLINE void store_skip(const LayerPass& pass, const TileRuns& runs, std::ptrdiff_t offset,
                           std::ptrdiff_t channel, const float* HWY_RESTRICT products) {
  const Lanes d;
  float* HWY_RESTRICT skip = pass.skip + channel * pass.stride;
  const bool add = pass.add_to_skip;
  for_columns(
      runs, offset, pass.order.places(),
      [=](std::ptrdiff_t place, std::ptrdiff_t column) HWY_ATTR {
        const Vector product = hn::Load(d, products + column);
        hn::StoreU(add ? hn::Add(hn::LoadU(d, skip + place), product) : product, d, skip + place);
      },
      [=](std::ptrdiff_t place, std::ptrdiff_t column)
          HWY_ATTR { skip[place] = add ? skip[place] + products[column] : products[column]; });
}

/// Zeros what next_x holds past the last sample, where this output of the tile wrote it.
HWY_INLINE void clear_past_end(const LayerPass& pass, const TileRuns& runs, std::ptrdiff_t offset) {
  const PlaneOrder& order = pass.order;
  for (std::ptrdiff_t t = order.samples; t < order.places(); ++t) {
    const std::ptrdiff_t place = order.place_of(t);
    for (std::ptrdiff_t i = 0; i < runs.begin[kTileVectors]; ++i) {
      const std::ptrdiff_t within = place - offset - runs.runs[i].place;
      if (within < 0 || within >= runs.runs[i].length) continue;
      for (std::ptrdiff_t channel = 0; channel < pass.channels; ++channel) {
        pass.next_x[channel * pass.stride + place] = 0.0F;
      }
    }
  }
}

/// Asks for the memory that the end of the tile will change, for the channels of one gate group.
template <std::ptrdiff_t kOutputs>
HWY_INLINE void prefetch_outputs(const LayerPass& pass, const Sweep& sweep, const TileRuns& runs,
                                 std::ptrdiff_t group) {
  const std::ptrdiff_t last = std::min((group + 1) * kGateChannels, pass.channels);
  for (std::ptrdiff_t channel = group * kGateChannels; channel < last; ++channel) {
    for (std::ptrdiff_t q = 0; q < kOutputs; ++q) {
      prefetch_columns(pass.skip + channel * pass.stride, runs, q * sweep.step);
      if (pass.next_x == nullptr) continue;
      prefetch_columns(pass.next_x + channel * pass.stride, runs, q * sweep.step);
    }
  }
}

/// Asks for what the thread will read next, for the channels of one group.
template <Scheme kScheme>
HWY_INLINE void prefetch_inputs(const LayerPass& pass, const Sweep& sweep, const TileRuns& runs,
                                std::ptrdiff_t group, std::ptrdiff_t part) {
  constexpr SchemeShape kShape = shape_of(kScheme);
  const std::ptrdiff_t inputs = kScheme == Scheme::taps ? sweep.taps : kShape.inputs;
  const std::ptrdiff_t last = std::min((group + 1) * kGroupRows, pass.channels);
  for (std::ptrdiff_t channel = group * kGroupRows; channel < last; ++channel) {
    for (std::ptrdiff_t i = part; i < inputs; i += kShape.outputs) {
      prefetch_columns(pass.x + channel * pass.stride, runs, sweep.first_offset + i * sweep.step);
    }
  }
}

template <Scheme kScheme>
HWY_NOINLINE void run_tile(const LayerPass& pass, const Sweep& sweep, std::ptrdiff_t tile,
                           const TileScratch& scratch) {
  constexpr SchemeShape kShape = shape_of(kScheme);
  const TileRuns runs = find_runs(sweep, tile);
  const std::ptrdiff_t channels = pass.channels;
  std::ptrdiff_t depth = channels;
  if constexpr (kScheme == Scheme::taps) {
    depth *= sweep.taps;
    Sweep tap = sweep;
    for (std::ptrdiff_t j = 0; j < sweep.taps; ++j) {
      fill_panel<kScheme>(pass, tap, runs, scratch.panel + j * channels * kTileColumns);
      tap.first_offset += sweep.step;
    }
  } else {
    fill_panel<kScheme>(pass, sweep, runs, scratch.panel);
  }

  const std::ptrdiff_t gate_groups = (channels + kGateChannels - 1) / kGateChannels;
  const std::ptrdiff_t output_stride = gate_groups * kGateChannels * kTileColumns;
  for (std::ptrdiff_t group = 0; group < gate_groups; ++group) {
    prefetch_outputs<kShape.outputs>(pass, sweep, runs, group);
    const float* weights = pass.gate_weights + group * pass.gate_group_stride;
    for (std::ptrdiff_t p = 0; p < kShape.positions; ++p) {
      multiply_group(weights + p * depth * kGroupRows, scratch.panel + p * depth * kTileColumns,
                     depth, scratch.products + p * kGroupRows * kTileColumns);
    }
    gate_group<kScheme>(scratch.products, pass.gate_constants + group * kGroupRows, output_stride,
                        scratch.gated + group * kGateChannels * kTileColumns);
  }

  const TileRuns next_runs = find_runs(sweep, tile + 1);
  const std::ptrdiff_t groups = (channels + kGroupRows - 1) / kGroupRows;
  for (std::ptrdiff_t q = 0; q < kShape.outputs; ++q) {
    const float* gated_channels = scratch.gated + q * output_stride;
    const std::ptrdiff_t offset = q * sweep.step;
    for (std::ptrdiff_t group = 0; group < groups; ++group) {
      const std::ptrdiff_t first = group * kGroupRows;
      const std::ptrdiff_t rows = std::min(kGroupRows, channels - first);
      const std::ptrdiff_t packed = first * channels;
      prefetch_inputs<kScheme>(pass, sweep, next_runs, group, q);
      if (pass.next_x != nullptr) {
        multiply_group(pass.residual_weights + packed, gated_channels, channels, scratch.products);
        for (std::ptrdiff_t r = 0; r < rows; ++r) {
          store_residual(pass, runs, offset, first + r, scratch.products + r * kTileColumns);
        }
      }
      multiply_group(pass.skip_weights + packed, gated_channels, channels, scratch.products);
      for (std::ptrdiff_t r = 0; r < rows; ++r) {
        store_skip(pass, runs, offset, first + r, scratch.products + r * kTileColumns);
      }
    }
    if (pass.next_x != nullptr && pass.order.segment != 0) clear_past_end(pass, runs, offset);
  }
}

}  // namespace earpoint::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
