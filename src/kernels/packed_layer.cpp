#include "packed_layer.h"

#include "gate_scale.h"
#include "packing.h"

#include <algorithm>

#include <earpoint/error.h>

namespace earpoint::kernels {

PackedLayer::PackedLayer(const GatedLayerWeights& weights, std::ptrdiff_t channels,
                         std::ptrdiff_t conditioning_width)
    : convolution_(weights.convolution),
      channels_(channels),
      filter_weight_(weights.filter_weight.begin(), weights.filter_weight.end()),
      gate_weight_(weights.gate_weight.begin(), weights.gate_weight.end()) {
  pack_constants(weights, conditioning_width);
  if (!weights.residual_weight.empty()) {
    residual_ = pack_rows(weights.residual_weight, channels, channels, 0.5);
    residual_bias_ = pack_vector(weights.residual_bias, 0.5);
  }
  skip_ = pack_rows(weights.skip_weight, channels, channels);
}

void PackedLayer::pack_constants(const GatedLayerWeights& weights,
                                 std::ptrdiff_t conditioning_width) {
  const std::ptrdiff_t rows = round_up(channels_, kGateChannels) * 2;
  biases_ = AlignedFloats(rows);
  conditioning_ = AlignedFloats(rows * conditioning_width);
  const auto pack = [&](std::ptrdiff_t row, std::ptrdiff_t channel, double scale,
                        std::span<const float> bias, std::span<const float> conditioning_bias,
                        std::span<const float> conditioning_weight) {
    const double sum = static_cast<double>(bias[channel]) + conditioning_bias[channel];
    biases_.data()[row] = static_cast<float>(scale * sum);
    for (std::ptrdiff_t i = 0; i < conditioning_width; ++i) {
      const float weight = conditioning_weight[channel * conditioning_width + i];
      conditioning_.data()[i * rows + row] = static_cast<float>(scale * weight);
    }
  };
  for (std::ptrdiff_t channel = 0; channel < channels_; ++channel) {
    const std::ptrdiff_t row =
        channel / kGateChannels * kGroupRows + filter_row(channel % kGateChannels);
    pack(row, channel, kFilterScale, weights.filter_bias, weights.filter_conditioning_bias,
         weights.filter_conditioning_weight);
    pack(row + kGateRowAfter, channel, kGateScale, weights.gate_bias,
         weights.gate_conditioning_bias, weights.gate_conditioning_weight);
  }
}

void PackedLayer::prepare(Scheme scheme) {
  AlignedFloats& packed = gate_[static_cast<std::size_t>(scheme)];
  if (packed.size() > 0) return;
  packed = pack_gate(scheme, filter_weight_, gate_weight_, channels_, convolution_.taps);
}

const float* PackedLayer::gate_weights(const Sweep& sweep) const {
  const AlignedFloats& packed = gate_[static_cast<std::size_t>(sweep.scheme)];
  EARPOINT_DCHECK(packed.size() > 0);
  return packed.data() + sweep.first_tap * channels_ * kGroupRows;
}

std::ptrdiff_t PackedLayer::gate_group_stride(const Sweep& sweep) const {
  const bool single = sweep.scheme == Scheme::taps;
  return (single ? convolution_.taps : shape_of(sweep.scheme).positions) * channels_ * kGroupRows;
}

void PackedLayer::condition(std::span<const float> conditioning, float* constants) const {
  const std::ptrdiff_t rows = biases_.size();
  std::copy_n(biases_.data(), rows, constants);
  const float* weights = conditioning_.data();
  for (const float value : conditioning) {
    for (std::ptrdiff_t row = 0; row < rows; ++row) constants[row] += weights[row] * value;
    weights += rows;
  }
}

PackedHead::PackedHead(const GatedStackWeights& weights)
    : first_weight(pack_rows(weights.first_weight, weights.channels, weights.channels,
                             1.0 / static_cast<double>(weights.layers.size()))),
      second_weight(pack_rows(weights.second_weight, weights.audio_channels, weights.channels)),
      second_bias(pack_vector(weights.second_bias)) {
  const double share = 1.0 / static_cast<double>(weights.layers.size());
  std::vector<float> bias;
  for (std::ptrdiff_t row = 0; row < weights.channels; ++row) {
    double sum = weights.first_bias[row];
    for (std::ptrdiff_t channel = 0; channel < weights.channels; ++channel) {
      double skip_bias = 0.0;
      for (const GatedLayerWeights& layer : weights.layers) skip_bias += layer.skip_bias[channel];
      sum += share * skip_bias * weights.first_weight[row * weights.channels + channel];
    }
    bias.push_back(static_cast<float>(sum));
  }
  first_bias = pack_vector(bias);
}

}  // namespace earpoint::kernels
