#include "gated_stack.h"

#include "aligned_floats.h"
#include "gate_scale.h"
#include "packing.h"
#include "phase_team.h"
#include "tile_kernels.h"

#include <algorithm>
#include <array>
#include <utility>

#include <earpoint/core/error.h>
#include <earpoint/core/parallel.h>

namespace earpoint::infer {
namespace {

constexpr int kSchemes = 4;

/// One layer's weights, packed.
struct PackedLayer {
  DilatedConvolution convolution;
  std::array<AlignedFloats, kSchemes> gate;  ///< by scheme; made when a plan needs it
  std::vector<float> filter_weight;          ///< what they are made of
  std::vector<float> gate_weight;

  /// Conditioning of the packed rows, scaled like them: [conditioning_width][rows].
  AlignedFloats conditioning;
  AlignedFloats constants;  ///< [rows]: their biases
  AlignedFloats residual;   ///< halved; empty in the last layer
  AlignedFloats residual_bias;
  AlignedFloats skip;
};

std::vector<float> copy_of(std::span<const float> values) { return {values.begin(), values.end()}; }

/// Biases and conditioning of filter and gate, in the order of the packed rows.
void pack_constants(const GatedLayerWeights& weights, int channels, int conditioning_width,
                    PackedLayer& packed) {
  const int rows = round_up(channels, kGateChannels) * 2;
  packed.constants = AlignedFloats(static_cast<std::size_t>(rows));
  packed.conditioning = AlignedFloats(static_cast<std::size_t>(rows) * conditioning_width);
  const auto pack = [&](int row, int channel, double scale, std::span<const float> bias,
                        std::span<const float> conditioning_bias,
                        std::span<const float> conditioning_weight) {
    packed.constants.data()[row] = static_cast<float>(
        scale * (static_cast<double>(bias[channel]) + conditioning_bias[channel]));
    for (int i = 0; i < conditioning_width; ++i) {
      const float weight =
          conditioning_weight[static_cast<std::size_t>(channel) * conditioning_width + i];
      packed.conditioning.data()[static_cast<std::size_t>(i) * rows + row] =
          static_cast<float>(scale * weight);
    }
  };
  for (int channel = 0; channel < channels; ++channel) {
    const int row = channel / kGateChannels * kGroupRows + filter_row(channel % kGateChannels);
    pack(row, channel, kFilterScale, weights.filter_bias, weights.filter_conditioning_bias,
         weights.filter_conditioning_weight);
    pack(row + kGateRowAfter, channel, kGateScale, weights.gate_bias,
         weights.gate_conditioning_bias, weights.gate_conditioning_weight);
  }
}

PackedLayer pack_layer(const GatedLayerWeights& weights, int channels, int conditioning_width) {
  PackedLayer packed;
  packed.convolution = weights.convolution;
  packed.filter_weight = copy_of(weights.filter_weight);
  packed.gate_weight = copy_of(weights.gate_weight);
  pack_constants(weights, channels, conditioning_width, packed);
  if (!weights.residual_weight.empty()) {
    packed.residual = pack_rows(weights.residual_weight, channels, channels, 0.5);
    packed.residual_bias = pack_vector(weights.residual_bias, 0.5);
  }
  packed.skip = pack_rows(weights.skip_weight, channels, channels);
  return packed;
}

}  // namespace

struct GatedStack::State {
  State(const GatedStackWeights& weights, int threads);

  void pack_head(const GatedStackWeights& weights);
  void pack_schemes();
  void allocate_planes();
  void condition(std::span<const float> conditioning);
  void order_source(std::span<const float> source);
  void work(int worker, std::span<float> output);
  [[nodiscard]] LayerPass layer_pass(std::size_t layer, bool first_in_order);

  int audio_channels;
  int channels;
  int conditioning_width;
  std::vector<PackedLayer> layers;
  std::vector<float> input_weight, input_bias;
  AlignedFloats first_weight, first_bias, second_weight, second_bias;

  ThreadPool pool;
  PhaseTeam team;
  std::vector<AlignedFloats> panels, products, gated;  ///< by worker
  AlignedFloats constants;                             ///< [layer][rows], with conditioning

  std::ptrdiff_t samples = 0;
  std::ptrdiff_t stride = 0;
  std::vector<LayerPlan> plans;
  AlignedFloats source;                 ///< [audio_channels][stride], in the first layer's order
  std::array<AlignedFloats, 2> x;       ///< [channels][stride]
  AlignedFloats skip_in_time;           ///< [channels][stride]
  AlignedFloats skip_in_segments;       ///< [channels][stride], if a layer has that order
  std::array<float*, 2> planes_of_x{};  ///< what a layer reads, what it writes
};

GatedStack::State::State(const GatedStackWeights& weights, int threads)
    : audio_channels(weights.audio_channels),
      channels(weights.channels),
      conditioning_width(weights.conditioning_width),
      pool(threads),
      team(threads) {
  EARPOINT_CHECK(audio_channels > 0 && channels > 0 && !weights.layers.empty());
  int taps = 1;
  for (const GatedLayerWeights& layer : weights.layers) {
    layers.push_back(pack_layer(layer, channels, conditioning_width));
    taps = std::max(taps, layer.convolution.taps);
  }
  input_weight = copy_of(weights.input_weight);
  input_bias = copy_of(weights.input_bias);
  pack_head(weights);

  const std::size_t tile_rows = static_cast<std::size_t>(round_up(channels, kGroupRows)) *
                                static_cast<std::size_t>(kTileColumns);
  for (int worker = 0; worker < threads; ++worker) {
    panels.emplace_back(tile_rows * std::max(kMostPositions, taps));
    products.emplace_back(static_cast<std::size_t>(kMostPositions) * kGroupRows * kTileColumns);
    gated.emplace_back(tile_rows * kMostOutputs);
  }
  constants = AlignedFloats(layers.size() * layers[0].constants.size());
}

/// The mean over the layers and the biases of the skips become part of the first convolution.
void GatedStack::State::pack_head(const GatedStackWeights& weights) {
  const double share = 1.0 / static_cast<double>(layers.size());
  first_weight = pack_rows(weights.first_weight, channels, channels, share);
  std::vector<float> bias(static_cast<std::size_t>(channels));
  for (int row = 0; row < channels; ++row) {
    double sum = weights.first_bias[row];
    for (int channel = 0; channel < channels; ++channel) {
      double skip_bias = 0.0;
      for (const GatedLayerWeights& layer : weights.layers) skip_bias += layer.skip_bias[channel];
      sum += share * skip_bias *
             weights.first_weight[static_cast<std::size_t>(row) * channels + channel];
    }
    bias[row] = static_cast<float>(sum);
  }
  first_bias = pack_vector(bias);
  second_weight = pack_rows(weights.second_weight, audio_channels, channels);
  second_bias = pack_vector(weights.second_bias);
}

/// Packs the convolutions for the schemes of the plans.
void GatedStack::State::pack_schemes() {
  for (std::size_t i = 0; i < layers.size(); ++i) {
    for (const Sweep& sweep : plans[i].used()) {
      AlignedFloats& packed = layers[i].gate[static_cast<std::size_t>(sweep.scheme)];
      if (packed.size() > 0) continue;
      packed = pack_gate(sweep.scheme, layers[i].filter_weight, layers[i].gate_weight, channels,
                         layers[i].convolution.taps);
    }
  }
}

void GatedStack::State::allocate_planes() {
  // Room for segments of equal length and for a tile past the end; an odd number of cache lines,
  // so that channels do not meet in the same cache set.
  const std::ptrdiff_t places = (samples + kSegments - 1) / kSegments * kSegments + kTileColumns;
  stride = (places + 15) / 16 * 16;
  if (stride / 16 % 2 == 0) stride += 16;
  const auto size = static_cast<std::size_t>(stride * channels);
  source = AlignedFloats(static_cast<std::size_t>(stride * audio_channels));
  x = {AlignedFloats(size), AlignedFloats(size)};
  skip_in_time = AlignedFloats(size);
  const bool segmented = std::any_of(plans.begin(), plans.end(),
                                     [](const LayerPlan& plan) { return plan.order.segment != 0; });
  skip_in_segments = segmented ? AlignedFloats(size) : AlignedFloats();
}

void GatedStack::State::condition(std::span<const float> conditioning) {
  const std::size_t rows = layers[0].constants.size();
  for (std::size_t i = 0; i < layers.size(); ++i) {
    float* row = constants.data() + i * rows;
    std::copy_n(layers[i].constants.data(), rows, row);
    const float* weights = layers[i].conditioning.data();
    for (const float value : conditioning) {
      for (std::size_t r = 0; r < rows; ++r) row[r] += weights[r] * value;
      weights += rows;
    }
  }
}

void GatedStack::State::order_source(std::span<const float> waveform) {
  const PlaneOrder& order = plans[0].order;
  for (int channel = 0; channel < audio_channels; ++channel) {
    const float* from = waveform.data() + channel * samples;
    float* to = source.data() + channel * stride;
    for (std::ptrdiff_t t = 0; t < samples; ++t) to[order.place_of(t)] = from[t];
  }
}

LayerPass GatedStack::State::layer_pass(std::size_t layer, bool first_in_order) {
  const PackedLayer& packed = layers[layer];
  const LayerPlan& plan = plans[layer];
  LayerPass pass;
  pass.order = plan.order;
  pass.channels = channels;
  pass.stride = stride;
  pass.skip = plan.order.segment != 0 ? skip_in_segments.data() : skip_in_time.data();
  pass.add_to_skip = !first_in_order;
  pass.tiles_ahead = pool.threads();
  pass.gate_constants = constants.data() + layer * packed.constants.size();
  pass.residual_weights = packed.residual.data();
  pass.residual_bias = packed.residual_bias.data();
  pass.skip_weights = packed.skip.data();
  return pass;
}

void GatedStack::State::work(int worker, std::span<float> output) {
  const TileScratch scratch{panels[worker].data(), products[worker].data(), gated[worker].data()};
  float* x_in = x[0].data();
  float* x_out = x[1].data();
  const auto each_channel = [&](const auto& task) { team.run_phase(channels, task); };

  PlaneOrder order = plans[0].order;
  const InputPass input{order, audio_channels,      stride,           source.data(),
                        x_in,  input_weight.data(), input_bias.data()};
  each_channel([&](std::ptrdiff_t c) { run_input_channel(input, static_cast<int>(c)); });

  bool used_time = false;
  bool used_segments = false;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const LayerPlan& plan = plans[i];
    const bool segmented = plan.order.segment != 0;
    if (segmented != (order.segment != 0)) {
      each_channel([&](std::ptrdiff_t c) {
        const float* from = x_in + c * stride;
        float* to = x_out + c * stride;
        segmented ? order_in_segments(plan.order, from, to) : order_in_time(order, from, to, false);
      });
      std::swap(x_in, x_out);
      order = plan.order;
    }

    bool& used = segmented ? used_segments : used_time;
    LayerPass pass = layer_pass(i, !used);
    used = true;
    pass.x = x_in;
    pass.next_x = i + 1 < layers.size() ? x_out : nullptr;
    team.run_phase(plan.tiles(), [&](std::ptrdiff_t tile) {
      const Sweep* sweep = plan.sweeps.data();
      for (; tile >= sweep->tiles(); ++sweep) tile -= sweep->tiles();
      const AlignedFloats& packed = layers[i].gate[static_cast<std::size_t>(sweep->scheme)];
      const int positions = sweep->scheme == Scheme::taps ? layers[i].convolution.taps
                                                          : shape_of(sweep->scheme).positions;
      LayerPass of_sweep = pass;
      of_sweep.gate_group_stride = static_cast<std::ptrdiff_t>(positions) * channels * kGroupRows;
      of_sweep.gate_weights =
          packed.data() + static_cast<std::ptrdiff_t>(sweep->first_tap) * channels * kGroupRows;
      run_layer_tile(of_sweep, *sweep, tile, scratch);
    });
    std::swap(x_in, x_out);
  }

  if (used_segments) {
    const PlaneOrder segmented{samples, (samples + kSegments - 1) / kSegments};
    each_channel([&](std::ptrdiff_t c) {
      order_in_time(segmented, skip_in_segments.data() + c * stride,
                    skip_in_time.data() + c * stride, used_time);
    });
  }
  OutputPass head{channels, audio_channels, samples, stride, skip_in_time.data()};
  head.first_weights = first_weight.data();
  head.first_bias = first_bias.data();
  head.second_weights = second_weight.data();
  head.second_bias = second_bias.data();
  head.output = output.data();
  team.run_phase((samples + kTileColumns - 1) / kTileColumns,
                 [&](std::ptrdiff_t tile) { run_output_tile(head, tile, scratch); });
}

GatedStack::GatedStack(const GatedStackWeights& weights, int threads)
    : state_(std::make_unique<State>(weights, threads)) {}
GatedStack::~GatedStack() = default;
GatedStack::GatedStack(GatedStack&&) noexcept = default;
GatedStack& GatedStack::operator=(GatedStack&&) noexcept = default;

void GatedStack::reserve(std::ptrdiff_t samples) {
  EARPOINT_CHECK(samples > 0);
  State& state = *state_;
  if (samples == state.samples) return;
  state.samples = samples;
  state.plans.clear();
  for (const PackedLayer& layer : state.layers) {
    state.plans.push_back(plan_layer(layer.convolution, samples));
  }
  state.pack_schemes();
  state.allocate_planes();
}

void GatedStack::run(std::span<const float> source, std::span<const float> conditioning,
                     std::span<float> output) {
  State& state = *state_;
  EARPOINT_CHECK(!source.empty() && source.size() % state.audio_channels == 0);
  EARPOINT_CHECK(std::ssize(conditioning) == state.conditioning_width);
  EARPOINT_CHECK(output.size() == source.size());
  reserve(std::ssize(source) / state.audio_channels);

  state.condition(conditioning);
  state.order_source(source);
  state.team.start();
  const int threads = state.pool.threads();
  state.pool.run(threads, [&](std::ptrdiff_t, int worker) { state.work(worker, output); });
}

}  // namespace earpoint::infer
