#include "fused_stack.h"

#include "stack_kernels.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

#include <earpoint/error.h>
#include <earpoint/kernels/aligned_floats.h>

namespace earpoint::training {
namespace {

/// Samples that are computed together: a multiple of the kernels' blocks of rows.
constexpr std::ptrdiff_t kTileRows = 96;

/// The memory is kept between passes, but not its contents.
void grow(AlignedFloats& floats, std::ptrdiff_t size) {
  if (floats.size() < size) floats = AlignedFloats(size);
}

void fill_rows(const float* row, std::ptrdiff_t columns, float* to, std::ptrdiff_t rows) {
  for (std::ptrdiff_t i = 0; i < rows; ++i) std::copy_n(row, columns, to + i * columns);
}

/// The buffers of one thread, for one tile.
struct Scratch {
  explicit Scratch(const StackShape& shape)
      : rows(kTileRows * shape.channels),
        more_rows(kTileRows * shape.channels),
        gates(kTileRows * 2 * shape.channels),
        edges(shape.taps * kTileRows * 2 * shape.channels),
        audio(kTileRows * kChannelStep),
        products(static_cast<std::size_t>(shape.taps)) {}

  AlignedFloats rows;
  AlignedFloats more_rows;
  AlignedFloats gates;
  AlignedFloats edges;
  AlignedFloats audio;
  std::vector<Product> products;
};

}  // namespace

/// A tile of a clip and the thread that works on it.
struct Part {
  std::ptrdiff_t clip = 0;
  std::ptrdiff_t slot = 0;   ///< of the gradients that are passed on from layer to layer
  std::ptrdiff_t first = 0;  ///< sample
  std::ptrdiff_t rows = 0;   ///< samples
  int thread = 0;
};

struct FusedStack::State {
  State(StackShape its_shape, int its_threads, ParallelLoop its_loop)
      : shape(std::move(its_shape)), threads(its_threads), loop(std::move(its_loop)) {
    EARPOINT_CHECK(shape.channels % kChannelStep == 0 && shape.audio_channels <= kChannelStep);
    EARPOINT_CHECK(shape.layers() > 0 && shape.taps > 0);
    scratch.reserve(static_cast<std::size_t>(threads));
    for (int i = 0; i < threads; ++i) scratch.emplace_back(shape);
  }

  void reserve(std::ptrdiff_t new_clips, std::ptrdiff_t new_samples, bool keep);
  template <class Work>
  void for_phases(std::ptrdiff_t phases, const Work& work);

  void input(const Part& part);
  void layer(const Part& part, std::ptrdiff_t layer);
  void head(const Part& part);
  void head_back(const Part& part);
  void gates_back(const Part& part, std::ptrdiff_t layer);
  void layer_back(const Part& part, std::ptrdiff_t layer);
  void input_back(const Part& part);

  /// Audio channels of a tile, side by side, padded with zeros.
  const float* audio_rows(const Part& part, const float* sounds);
  std::span<const Product> tap_products(const Part& part, const float* plane, std::ptrdiff_t width,
                                        std::ptrdiff_t layer, bool forwards, const float* matrices,
                                        std::ptrdiff_t columns);

  Scratch& of(const Part& part) { return scratch[static_cast<std::size_t>(part.thread)]; }
  /// Row 0 of the clip in the input of layer `index`. Unless they are kept, layers share two
  /// planes.
  float* x(const Part& part, std::ptrdiff_t index) {
    const std::ptrdiff_t plane =
        kept ? part.clip * shape.layers() + index : part.clip * 2 + index % 2;
    return x_planes.data() + plane * samples * shape.channels;
  }
  float* gates(const Part& part, std::ptrdiff_t index) {
    if (!kept) return of(part).gates.data();
    return gate_planes.data() +
           ((part.clip * shape.layers() + index) * samples + part.first) * 2 * shape.channels;
  }
  float* skip(const Part& part) {
    return skips.data() + (part.clip * samples + part.first) * shape.channels;
  }
  float* by_x(const Part& part) {
    return by_x_planes.data() + (part.slot * samples + part.first) * shape.channels;
  }
  /// Row 0 of the clip.
  float* by_gates(const Part& part) {
    return by_gate_planes.data() + part.slot * samples * 2 * shape.channels;
  }
  /// How far from its output a tap reads, in samples.
  [[nodiscard]] std::ptrdiff_t offset(std::ptrdiff_t index, std::ptrdiff_t tap) const {
    return (tap - shape.centre) * shape.dilations[static_cast<std::size_t>(index)];
  }
  StackParameters<float>& gradient(const Part& part) {
    return gradients[static_cast<std::size_t>(part.thread)];
  }

  StackShape shape;
  int threads;
  ParallelLoop loop;
  std::vector<Scratch> scratch;

  std::ptrdiff_t clips = 0;
  std::ptrdiff_t samples = 0;
  bool kept = false;
  AlignedFloats x_planes;        ///< [clips][layers][samples][channels]
  AlignedFloats gate_planes;     ///< [clips][layers][samples][2 channels], see open_gates()
  AlignedFloats skips;           ///< [clips][samples][channels], later the gradient by it
  AlignedFloats by_x_planes;     ///< [slots][samples][channels]
  AlignedFloats by_gate_planes;  ///< [slots][samples][2 channels]

  // Of the present pass.
  StackParameters<const float> weights;
  TransposedParameters transposed;
  const float* source = nullptr;
  const float* by_output = nullptr;
  float* output = nullptr;
  std::vector<StackParameters<float>> gradients;  ///< of each thread
};

void FusedStack::State::reserve(std::ptrdiff_t new_clips, std::ptrdiff_t new_samples, bool keep) {
  clips = new_clips;
  samples = new_samples;
  kept = keep;
  const std::ptrdiff_t plane = samples * shape.channels;
  grow(x_planes, clips * plane * (keep ? shape.layers() : 2));
  grow(skips, clips * plane);
  if (!keep) return;
  grow(gate_planes, clips * shape.layers() * 2 * plane);
  const std::ptrdiff_t slots = std::max<std::ptrdiff_t>(clips, threads);
  grow(by_x_planes, slots * plane);
  grow(by_gate_planes, slots * 2 * plane);
}

/// Calls work(phase, part) for all parts of all clips, for one phase after the other in each clip.
template <class Work>
void FusedStack::State::for_phases(std::ptrdiff_t phases, const Work& work) {
  const std::ptrdiff_t tiles = (samples + kTileRows - 1) / kTileRows;
  const auto part_of = [&](std::ptrdiff_t clip, std::ptrdiff_t tile, int thread) {
    const std::ptrdiff_t first = tile * kTileRows;
    return Part{.clip = clip,
                .slot = clip,
                .first = first,
                .rows = std::min(kTileRows, samples - first),
                .thread = thread};
  };
  if (clips % threads == 0) {
    // Clip by clip, so that each phase finds the results of the last in the cache.
    loop(clips, [&](std::ptrdiff_t begin, std::ptrdiff_t end, int thread) {
      for (std::ptrdiff_t clip = begin; clip < end; ++clip) {
        for (std::ptrdiff_t phase = 0; phase < phases; ++phase) {
          for (std::ptrdiff_t tile = 0; tile < tiles; ++tile) {
            Part part = part_of(clip, tile, thread);
            part.slot = thread;
            work(phase, part);
          }
        }
      }
    });
    return;
  }
  for (std::ptrdiff_t phase = 0; phase < phases; ++phase) {
    loop(clips * tiles, [&](std::ptrdiff_t begin, std::ptrdiff_t end, int thread) {
      for (std::ptrdiff_t i = begin; i < end; ++i) {
        work(phase, part_of(i / tiles, i % tiles, thread));
      }
    });
  }
}

const float* FusedStack::State::audio_rows(const Part& part, const float* sounds) {
  float* to = of(part).audio.data();
  std::fill_n(to, part.rows * kChannelStep, 0.0F);
  for (std::ptrdiff_t channel = 0; channel < shape.audio_channels; ++channel) {
    const float* from =
        sounds + (part.clip * shape.audio_channels + channel) * samples + part.first;
    for (std::ptrdiff_t i = 0; i < part.rows; ++i) to[i * kChannelStep + channel] = from[i];
  }
  return to;
}

/// One product for each tap that reads any sound. Rows beyond the clip's ends are zeros.
/// @param plane      row 0 of what is read, `width` wide
/// @param forwards   taps read where the convolution does, else where it writes
/// @param matrices   [taps][width][columns]
std::span<const Product> FusedStack::State::tap_products(const Part& part, const float* plane,
                                                         std::ptrdiff_t width, std::ptrdiff_t layer,
                                                         bool forwards, const float* matrices,
                                                         std::ptrdiff_t columns) {
  Scratch& memory = of(part);
  std::size_t count = 0;
  for (std::ptrdiff_t tap = 0; tap < shape.taps; ++tap) {
    const std::ptrdiff_t begin = part.first + (forwards ? 1 : -1) * offset(layer, tap);
    const std::ptrdiff_t before = std::clamp<std::ptrdiff_t>(-begin, 0, part.rows);
    const std::ptrdiff_t end = std::clamp<std::ptrdiff_t>(samples - begin, before, part.rows);
    if (before == end) continue;
    const float* rows = plane + begin * width;
    if (end - before < part.rows) {
      float* copy = memory.edges.data() + tap * kTileRows * width;
      std::fill_n(copy, part.rows * width, 0.0F);
      std::copy(plane + (begin + before) * width, plane + (begin + end) * width,
                copy + before * width);
      rows = copy;
    }
    memory.products[count++] = {rows, width, width, matrices + tap * width * columns, columns};
  }
  return {memory.products.data(), count};
}

void FusedStack::State::input(const Part& part) {
  const std::ptrdiff_t c = shape.channels;
  float* to = x(part, 0) + part.first * c;
  fill_rows(weights.input_bias, c, to, part.rows);
  const Product product{audio_rows(part, source), kChannelStep, shape.audio_channels, weights.input,
                        c};
  add_products({&product, 1}, to, c, part.rows, c);
}

void FusedStack::State::layer(const Part& part, std::ptrdiff_t layer) {
  const std::ptrdiff_t c = shape.channels;
  const float* plane = x(part, layer);
  float* opened = gates(part, layer);
  float* gated = of(part).rows.data();
  fill_rows(weights.constants + (part.clip * shape.layers() + layer) * 2 * c, 2 * c, opened,
            part.rows);
  add_products(tap_products(part, plane, c, layer, true,
                            weights.gate + layer * shape.taps * c * 2 * c, 2 * c),
               opened, 2 * c, part.rows, 2 * c);
  open_gates(opened, gated, part.rows, c);

  if (layer + 1 < shape.layers()) {
    float* next = x(part, layer + 1) + part.first * c;
    scale_rows(plane + part.first * c, 0.5F, weights.residual_bias + layer * c, next, c, part.rows,
               c);
    const Product product{gated, c, c, weights.residual + layer * c * c, c};
    add_products({&product, 1}, next, c, part.rows, c);
  }
  if (layer == 0) fill_rows(weights.skip_bias, c, skip(part), part.rows);
  const Product product{gated, c, c, weights.skip + layer * c * c, c};
  add_products({&product, 1}, skip(part), c, part.rows, c);
}

void FusedStack::State::head(const Part& part) {
  const std::ptrdiff_t c = shape.channels;
  float* hidden = of(part).rows.data();
  fill_rows(weights.first_bias, c, hidden, part.rows);
  const Product first{skip(part), c, c, weights.first, c};
  add_products({&first, 1}, hidden, c, part.rows, c);
  sines(hidden, part.rows * c);

  float* rows = of(part).audio.data();
  fill_rows(weights.second_bias, kChannelStep, rows, part.rows);
  const Product second{hidden, c, c, weights.second, kChannelStep};
  add_products({&second, 1}, rows, kChannelStep, part.rows, kChannelStep);
  for (std::ptrdiff_t channel = 0; channel < shape.audio_channels; ++channel) {
    float* to = output + (part.clip * shape.audio_channels + channel) * samples + part.first;
    for (std::ptrdiff_t i = 0; i < part.rows; ++i) to[i] = rows[i * kChannelStep + channel];
  }
}

void FusedStack::State::head_back(const Part& part) {
  const std::ptrdiff_t c = shape.channels;
  const StackParameters<float>& to = gradient(part);
  float* hidden = of(part).rows.data();
  float* by_hidden = of(part).more_rows.data();
  const float* by_audio = audio_rows(part, by_output);
  fill_rows(weights.first_bias, c, hidden, part.rows);
  const Product first{skip(part), c, c, weights.first, c};
  add_products({&first, 1}, hidden, c, part.rows, c);
  std::fill_n(by_hidden, part.rows * c, 0.0F);
  const Product second{by_audio, kChannelStep, shape.audio_channels, transposed.second, c};
  add_products({&second, 1}, by_hidden, c, part.rows, c);
  sines_back(hidden, by_hidden, part.rows * c);

  add_outer_products({hidden, c, by_audio, kChannelStep, part.rows, c, kChannelStep, to.second});
  add_rows(by_audio, kChannelStep, part.rows, kChannelStep, to.second_bias);
  add_outer_products({skip(part), c, by_hidden, c, part.rows, c, c, to.first});
  add_rows(by_hidden, c, part.rows, c, to.first_bias);

  std::fill_n(skip(part), part.rows * c, 0.0F);
  const Product back{by_hidden, c, c, transposed.first, c};
  add_products({&back, 1}, skip(part), c, part.rows, c);
  add_rows(skip(part), c, part.rows, c, to.skip_bias);
}

/// Computes the gradients by the gates of a layer and by its weights.
void FusedStack::State::gates_back(const Part& part, std::ptrdiff_t layer) {
  const std::ptrdiff_t c = shape.channels;
  const StackParameters<float>& to = gradient(part);
  const bool last = layer + 1 == shape.layers();
  float* gated = of(part).rows.data();
  std::fill_n(gated, part.rows * c, 0.0F);
  const Product ways[] = {{skip(part), c, c, transposed.skip + layer * c * c, c},
                          {by_x(part), c, c, transposed.residual + layer * c * c, c}};
  add_products({ways, last ? 1U : 2U}, gated, c, part.rows, c);
  float* by_opened = by_gates(part) + part.first * 2 * c;
  open_gates_back(gates(part, layer), gated, by_opened,
                  to.constants + (part.clip * shape.layers() + layer) * 2 * c, part.rows, c);

  add_outer_products({gated, c, skip(part), c, part.rows, c, c, to.skip + layer * c * c});
  if (!last) {
    add_outer_products({gated, c, by_x(part), c, part.rows, c, c, to.residual + layer * c * c});
    add_rows(by_x(part), c, part.rows, c, to.residual_bias + layer * c);
  }
  for (std::ptrdiff_t tap = 0; tap < shape.taps; ++tap) {
    const std::ptrdiff_t begin = part.first + offset(layer, tap);
    const std::ptrdiff_t before = std::clamp<std::ptrdiff_t>(-begin, 0, part.rows);
    const std::ptrdiff_t end = std::clamp<std::ptrdiff_t>(samples - begin, before, part.rows);
    if (before == end) continue;
    add_outer_products({x(part, layer) + (begin + before) * c, c, by_opened + before * 2 * c, 2 * c,
                        end - before, c, 2 * c, to.gate + (layer * shape.taps + tap) * c * 2 * c});
  }
}

/// Computes the gradient by a layer's input from those by its gates.
void FusedStack::State::layer_back(const Part& part, std::ptrdiff_t layer) {
  const std::ptrdiff_t c = shape.channels;
  float* rows = by_x(part);
  if (layer + 1 == shape.layers()) {
    std::fill_n(rows, part.rows * c, 0.0F);
  } else {
    for (std::ptrdiff_t i = 0; i < part.rows * c; ++i) rows[i] *= 0.5F;
  }
  add_products(tap_products(part, by_gates(part), 2 * c, layer, false,
                            transposed.gate + layer * shape.taps * 2 * c * c, c),
               rows, c, part.rows, c);
}

void FusedStack::State::input_back(const Part& part) {
  const std::ptrdiff_t c = shape.channels;
  add_outer_products({audio_rows(part, source), kChannelStep, by_x(part), c, part.rows,
                      kChannelStep, c, gradient(part).input});
  add_rows(by_x(part), c, part.rows, c, gradient(part).input_bias);
}

FusedStack::FusedStack(StackShape shape, int threads, ParallelLoop loop)
    : state_(std::make_unique<State>(std::move(shape), threads, std::move(loop))) {}
FusedStack::~FusedStack() = default;

void FusedStack::forward(const StackParameters<const float>& weights, const float* source,
                         std::ptrdiff_t clips, std::ptrdiff_t samples, bool keep, float* output) {
  State& state = *state_;
  state.reserve(clips, samples, keep);
  state.weights = weights;
  state.source = source;
  state.output = output;
  const std::ptrdiff_t layers = state.shape.layers();
  state.for_phases(layers + 2, [&](std::ptrdiff_t phase, const Part& part) {
    if (phase == 0) {
      state.input(part);
    } else if (phase <= layers) {
      state.layer(part, phase - 1);
    } else {
      state.head(part);
    }
  });
}

void FusedStack::backward(const StackParameters<const float>& weights,
                          const TransposedParameters& transposed, const float* source,
                          const float* by_output, float* gradients) {
  State& state = *state_;
  EARPOINT_CHECK(state.kept);
  state.weights = weights;
  state.transposed = transposed;
  state.source = source;
  state.by_output = by_output;
  const StackSizes sizes = stack_sizes(state.shape, state.clips);
  const std::ptrdiff_t size = std::accumulate(sizes.begin(), sizes.end(), std::ptrdiff_t{0});
  state.gradients.clear();
  for (int thread = 0; thread < state.threads; ++thread) {
    state.gradients.push_back(consecutive(sizes, gradients + thread * size));
  }
  const std::ptrdiff_t layers = state.shape.layers();
  state.for_phases(2 * layers + 2, [&](std::ptrdiff_t phase, const Part& part) {
    const std::ptrdiff_t layer = layers - 1 - (phase - 1) / 2;
    if (phase == 0) {
      state.head_back(part);
    } else if (phase == 2 * layers + 1) {
      state.input_back(part);
    } else if (phase % 2 == 1) {
      state.gates_back(part, layer);
    } else {
      state.layer_back(part, layer);
    }
  });
  state.kept = false;
}

}  // namespace earpoint::training
