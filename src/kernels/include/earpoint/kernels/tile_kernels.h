#pragma once

#include <cstddef>

#include <earpoint/kernels/lattice.h>
#include <earpoint/kernels/tile_shape.h>

namespace earpoint::kernels {

/// The order of samples in a plane (one channel).
struct PlaneOrder {
  std::ptrdiff_t samples = 0;  ///< of the waveform
  /// 0: in time. Else the samples of a segment, and sample t lies at
  /// (t % segment) * kSegments + t / segment: a dilation of d is then a step of d * kSegments, so
  /// that small dilations also move whole vectors.
  std::ptrdiff_t segment = 0;

  /// Places in a plane, at least `samples`. Those past the last sample hold zeros.
  [[nodiscard]] std::ptrdiff_t places() const {
    return segment == 0 ? samples : segment * kSegments;
  }

  /// Where sample t lies.
  [[nodiscard]] std::ptrdiff_t place_of(std::ptrdiff_t t) const {
    return segment == 0 ? t : (t % segment) * kSegments + t / segment;
  }
};

/// Outputs of one layer that are computed in one way. Its columns are numbered group by group:
/// column n stands for the outputs at
///   (n / width) * outputs * step + phase + n % width + q * step,  0 <= q < outputs.
struct Sweep {
  Scheme scheme = Scheme::taps;
  std::ptrdiff_t first_tap = 0;  ///< of the taps that can see samples; Scheme::taps only
  std::ptrdiff_t taps = 0;
  std::ptrdiff_t first_offset = 0;  ///< of the first input from the first output, in places
  std::ptrdiff_t step = 0;          ///< the dilation, in places
  std::ptrdiff_t phase = 0;
  std::ptrdiff_t width = 0;
  std::ptrdiff_t columns = 0;

  [[nodiscard]] std::ptrdiff_t tiles() const { return (columns + kTileColumns - 1) / kTileColumns; }
};

/// One layer of the gated stack, on planes of shape [channels][stride].
struct LayerPass {
  PlaneOrder order;
  std::ptrdiff_t channels = 0;
  std::ptrdiff_t stride = 0;
  const float* x = nullptr;
  float* next_x = nullptr;  ///< (residual + x) / 2; null if nobody reads it
  float* skip = nullptr;
  bool add_to_skip = true;  ///< else it is written

  /// Packed weights of the filter and gate rows: [group][position][depth][kGroupRows], where the
  /// depth counts channels (or, for Scheme::taps, taps and channels).
  const float* gate_weights = nullptr;
  std::ptrdiff_t gate_group_stride = 0;   ///< floats from one group to the next
  const float* gate_constants = nullptr;  ///< [group][kGroupRows]: biases and conditioning

  /// Packed rows of the residual (halved), then of the skip: [group][channels][kGroupRows].
  const float* residual_weights = nullptr;
  const float* residual_bias = nullptr;  ///< halved, [groups * kGroupRows]
  const float* skip_weights = nullptr;
};

/// Memory that one thread works in, all aligned to 64 bytes.
struct TileScratch {
  float* panel = nullptr;     ///< [positions][depth][kTileColumns]
  float* products = nullptr;  ///< [kMostPositions][kGroupRows][kTileColumns]
  float* gated = nullptr;     ///< [kMostOutputs][gate channels][kTileColumns]
};

/// Computes one tile of a sweep: convolution, gate, residual and skip.
void run_layer_tile(const LayerPass& pass, const Sweep& sweep, std::ptrdiff_t tile,
                    const TileScratch& scratch);

/// The first layer of the network: planes of the waveform's channels to planes of the stack.
struct InputPass {
  PlaneOrder order;
  std::ptrdiff_t audio_channels = 0;
  std::ptrdiff_t stride = 0;
  const float* source = nullptr;  ///< [audio_channels][stride]
  float* x = nullptr;
  const float* weights = nullptr;  ///< [channels][audio_channels]
  const float* bias = nullptr;     ///< [channels]
};

/// Computes one channel of it.
void run_input_channel(const InputPass& pass, std::ptrdiff_t channel);

/// The last two layers: 1x1, sine, 1x1.
struct OutputPass {
  std::ptrdiff_t channels = 0;
  std::ptrdiff_t audio_channels = 0;
  std::ptrdiff_t samples = 0;
  std::ptrdiff_t stride = 0;
  const float* skip = nullptr;            ///< in time
  const float* first_weights = nullptr;   ///< packed, [group][channels][kGroupRows]
  const float* first_bias = nullptr;      ///< [groups * kGroupRows]
  const float* second_weights = nullptr;  ///< packed, [group][channels][kGroupRows]
  const float* second_bias = nullptr;     ///< [groups * kGroupRows]
  float* output = nullptr;                ///< [audio_channels][samples]
};

/// Computes kTileColumns samples of it.
void run_output_tile(const OutputPass& pass, std::ptrdiff_t tile, const TileScratch& scratch);

/// Copies one plane from time order to segmented order, with zeros past the last sample.
void order_in_segments(const PlaneOrder& segmented, const float* in_time, float* in_segments);

/// Copies one plane back to time order, or adds it there.
void order_in_time(const PlaneOrder& segmented, const float* in_segments, float* in_time, bool add);

}  // namespace earpoint::kernels
