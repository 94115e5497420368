#include <earpoint/kernels/gated_stack.h>

#include "packed_layer.h"
#include "phase_team.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <earpoint/core/parallel.h>
#include <earpoint/error.h>
#include <earpoint/kernels/aligned_floats.h>
#include <earpoint/kernels/tile_kernels.h>

namespace earpoint::kernels {
namespace {

/// Working memory of one thread.
struct WorkerMemory {
  WorkerMemory(std::ptrdiff_t channels, std::ptrdiff_t most_taps)
      : panel(std::max(kMostPositions, most_taps) * round_up(channels, kGroupRows) * kTileColumns),
        products(kMostPositions * kGroupRows * kTileColumns),
        gated(kMostOutputs * round_up(channels, kGroupRows) * kTileColumns) {}

  [[nodiscard]] TileScratch scratch() {
    return {.panel = panel.data(), .products = products.data(), .gated = gated.data()};
  }

  AlignedFloats panel;
  AlignedFloats products;
  AlignedFloats gated;
};

/// A thread's view of the run; except for `member`, the same in every thread at the same phase.
struct Progress {
  int member = 0;                 ///< of the team: the thread itself
  float* x = nullptr;             ///< [channels][stride], what the next layer reads
  float* next_x = nullptr;        ///< what it writes
  PlaneOrder order;               ///< of x
  bool skip_in_time = false;      ///< whether that sum has been begun
  bool skip_in_segments = false;  ///< whether that sum has been begun
};

}  // namespace

struct GatedStack::State {
  State(const GatedStackWeights& weights, int threads);

  void plan(std::ptrdiff_t new_samples);
  void condition(std::span<const float> conditioning);
  void order_source(std::span<const float> waveform);
  void work(int member, std::span<float> output);

  // Phases of work(). Every thread of the team calls them in the same order.
  Progress run_input(int member);
  void change_order(Progress& progress, const PlaneOrder& order);
  void run_layer(Progress& progress, std::size_t layer);
  void run_head(const Progress& progress, std::span<float> output);

  std::ptrdiff_t audio_channels;
  std::ptrdiff_t channels;
  std::ptrdiff_t conditioning_width;
  std::vector<float> input_weight;
  std::vector<float> input_bias;
  std::vector<PackedLayer> layers;
  PackedHead head;

  ThreadPool pool;
  PhaseTeam team;
  std::vector<WorkerMemory> workers;
  AlignedFloats constants;  ///< [layer][rows]: biases and conditioning

  std::ptrdiff_t samples = 0;
  std::ptrdiff_t stride = 0;
  std::vector<LayerPlan> plans;
  AlignedFloats source;            ///< [audio_channels][stride], in the first layer's order
  std::array<AlignedFloats, 2> x;  ///< [channels][stride]
  // The sums of the skip outputs, [channels][stride]: one sum for the layers in each order.
  AlignedFloats skip_in_time;
  AlignedFloats skip_in_segments;
};

GatedStack::State::State(const GatedStackWeights& weights, int threads)
    : audio_channels(weights.audio_channels),
      channels(weights.channels),
      conditioning_width(weights.conditioning_width),
      input_weight(weights.input_weight.begin(), weights.input_weight.end()),
      input_bias(weights.input_bias.begin(), weights.input_bias.end()),
      head(weights),
      pool(threads),
      team(threads) {
  EARPOINT_CHECK(audio_channels > 0 && channels > 0 && !weights.layers.empty());
  std::ptrdiff_t taps = 1;
  for (const GatedLayerWeights& layer : weights.layers) {
    layers.emplace_back(layer, channels, conditioning_width);
    taps = std::max(taps, layer.convolution.taps);
  }
  for (int worker = 0; worker < threads; ++worker) workers.emplace_back(channels, taps);
  constants = AlignedFloats(std::ssize(layers) * layers[0].constants());
}

void GatedStack::State::plan(std::ptrdiff_t new_samples) {
  samples = new_samples;
  plans.clear();
  bool segmented = false;
  for (PackedLayer& layer : layers) {
    const LayerPlan& plan = plans.emplace_back(plan_layer(layer.convolution(), samples));
    for (const Sweep& sweep : plan.used()) layer.prepare(sweep.scheme);
    segmented = segmented || plan.order.segment != 0;
  }

  // Room for segments of equal length and for a tile past the end; an odd number of cache lines,
  // so that the channels' planes do not meet in the same sets of a cache.
  constexpr std::ptrdiff_t kCacheLine = 16;
  stride = round_up(round_up(samples, kSegments) + kTileColumns, kCacheLine);
  if (stride / kCacheLine % 2 == 0) stride += kCacheLine;
  source = AlignedFloats(audio_channels * stride);
  x = {AlignedFloats(channels * stride), AlignedFloats(channels * stride)};
  skip_in_time = AlignedFloats(channels * stride);
  skip_in_segments = AlignedFloats(segmented ? channels * stride : 0);
}

void GatedStack::State::condition(std::span<const float> conditioning) {
  float* of_layer = constants.data();
  for (const PackedLayer& layer : layers) {
    layer.condition(conditioning, of_layer);
    of_layer += layer.constants();
  }
}

void GatedStack::State::order_source(std::span<const float> waveform) {
  const PlaneOrder& order = plans[0].order;
  for (std::ptrdiff_t channel = 0; channel < audio_channels; ++channel) {
    const std::span<const float> from = waveform.subspan(channel * samples, samples);
    float* to = source.data() + channel * stride;
    for (std::ptrdiff_t t = 0; t < samples; ++t) to[order.place_of(t)] = from[t];
  }
}

void GatedStack::State::work(int member, std::span<float> output) {
  Progress progress = run_input(member);
  for (std::size_t layer = 0; layer < layers.size(); ++layer) {
    change_order(progress, plans[layer].order);
    run_layer(progress, layer);
  }
  run_head(progress, output);
}

Progress GatedStack::State::run_input(int member) {
  Progress progress{
      .member = member, .x = x[0].data(), .next_x = x[1].data(), .order = plans[0].order};
  const InputPass pass{.order = progress.order,
                       .audio_channels = audio_channels,
                       .stride = stride,
                       .source = source.data(),
                       .x = progress.x,
                       .weights = input_weight.data(),
                       .bias = input_bias.data()};
  team.run_phase(member, channels,
                 [&](std::ptrdiff_t channel) { run_input_channel(pass, channel); });
  return progress;
}

void GatedStack::State::change_order(Progress& progress, const PlaneOrder& order) {
  if (order.segment == progress.order.segment) return;
  team.run_phase(progress.member, channels, [&](std::ptrdiff_t channel) {
    const float* from = progress.x + channel * stride;
    float* to = progress.next_x + channel * stride;
    if (order.segment != 0) {
      order_in_segments(order, from, to);
    } else {
      order_in_time(progress.order, from, to, false);
    }
  });
  std::swap(progress.x, progress.next_x);
  progress.order = order;
}

void GatedStack::State::run_layer(Progress& progress, std::size_t layer) {
  const TileScratch scratch = workers[static_cast<std::size_t>(progress.member)].scratch();
  const PackedLayer& packed = layers[layer];
  const LayerPlan& plan = plans[layer];
  const bool segmented = plan.order.segment != 0;
  bool& skip_begun = segmented ? progress.skip_in_segments : progress.skip_in_time;

  LayerPass pass;
  pass.order = plan.order;
  pass.channels = channels;
  pass.stride = stride;
  pass.x = progress.x;
  pass.next_x = layer + 1 < layers.size() ? progress.next_x : nullptr;
  pass.skip = segmented ? skip_in_segments.data() : skip_in_time.data();
  pass.add_to_skip = skip_begun;
  pass.gate_constants = constants.data() + static_cast<std::ptrdiff_t>(layer) * packed.constants();
  pass.residual_weights = packed.residual();
  pass.residual_bias = packed.residual_bias();
  pass.skip_weights = packed.skip();
  team.run_phase(progress.member, plan.tiles(), [&](std::ptrdiff_t tile) {
    const Sweep* sweep = plan.sweeps.data();
    for (; tile >= sweep->tiles(); ++sweep) tile -= sweep->tiles();
    LayerPass of_sweep = pass;
    of_sweep.gate_weights = packed.gate_weights(*sweep);
    of_sweep.gate_group_stride = packed.gate_group_stride(*sweep);
    run_layer_tile(of_sweep, *sweep, tile, scratch);
  });
  skip_begun = true;
  std::swap(progress.x, progress.next_x);
}

void GatedStack::State::run_head(const Progress& progress, std::span<float> output) {
  const TileScratch scratch = workers[static_cast<std::size_t>(progress.member)].scratch();
  if (progress.skip_in_segments) {
    const PlaneOrder segmented{.samples = samples,
                               .segment = round_up(samples, kSegments) / kSegments};
    team.run_phase(progress.member, channels, [&](std::ptrdiff_t channel) {
      order_in_time(segmented, skip_in_segments.data() + channel * stride,
                    skip_in_time.data() + channel * stride, progress.skip_in_time);
    });
  }
  const OutputPass pass{.channels = channels,
                        .audio_channels = audio_channels,
                        .samples = samples,
                        .stride = stride,
                        .skip = skip_in_time.data(),
                        .first_weights = head.first_weight.data(),
                        .first_bias = head.first_bias.data(),
                        .second_weights = head.second_weight.data(),
                        .second_bias = head.second_bias.data(),
                        .output = output.data()};
  team.run_phase(progress.member, round_up(samples, kTileColumns) / kTileColumns,
                 [&](std::ptrdiff_t tile) { run_output_tile(pass, tile, scratch); });
}

GatedStack::GatedStack(const GatedStackWeights& weights, int threads)
    : state_(std::make_unique<State>(weights, threads)) {}
GatedStack::~GatedStack() = default;
GatedStack::GatedStack(GatedStack&&) noexcept = default;
GatedStack& GatedStack::operator=(GatedStack&&) noexcept = default;

void GatedStack::reserve(std::ptrdiff_t samples) {
  EARPOINT_CHECK(samples > 0);
  if (samples != state_->samples) state_->plan(samples);
}

void GatedStack::run(std::span<const float> source, std::span<const float> conditioning,
                     std::span<float> output) {
  State& state = *state_;
  EARPOINT_CHECK(!source.empty() && std::ssize(source) % state.audio_channels == 0);
  EARPOINT_CHECK(std::ssize(conditioning) == state.conditioning_width);
  EARPOINT_CHECK(output.size() == source.size());
  reserve(std::ssize(source) / state.audio_channels);

  state.condition(conditioning);
  state.order_source(source);
  state.team.start();
  state.pool.run(state.pool.threads(),
                 [&](std::ptrdiff_t, int worker) { state.work(worker, output); });
}

}  // namespace earpoint::kernels
