#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/kernels/aligned_floats.h>
#include <earpoint/kernels/stack_plan.h>
#include <earpoint/kernels/stack_weights.h>

namespace earpoint::kernels {

/// One layer's weights as the tile kernels want them.
class PackedLayer {
 public:
  PackedLayer(const GatedLayerWeights& weights, std::ptrdiff_t channels,
              std::ptrdiff_t conditioning_width);

  [[nodiscard]] const DilatedConvolution& convolution() const { return convolution_; }

  /// Packs the convolution for a scheme, if that has not been done.
  void prepare(Scheme scheme);

  /// Filter and gate rows bare of their biases, for one sweep; see LayerPass::gate_weights.
  /// Its scheme was prepared.
  [[nodiscard]] const float* gate_weights(const Sweep& sweep) const;
  [[nodiscard]] std::ptrdiff_t gate_group_stride(const Sweep& sweep) const;

  /// Biases and conditioning, in the order of the packed rows: [gate groups][kGroupRows].
  [[nodiscard]] std::ptrdiff_t constants() const { return biases_.size(); }
  void condition(std::span<const float> conditioning, float* constants) const;

  [[nodiscard]] const float* residual() const { return residual_.data(); }
  [[nodiscard]] const float* residual_bias() const { return residual_bias_.data(); }
  [[nodiscard]] const float* skip() const { return skip_.data(); }

 private:
  void pack_constants(const GatedLayerWeights& weights, std::ptrdiff_t conditioning_width);

  static constexpr std::size_t kSchemes = 4;

  DilatedConvolution convolution_;
  std::ptrdiff_t channels_;
  std::vector<float> filter_weight_;  // what gate_ is made of
  std::vector<float> gate_weight_;
  std::array<AlignedFloats, kSchemes> gate_;  // by scheme, empty until prepared
  AlignedFloats biases_;
  AlignedFloats conditioning_;  // [conditioning_width][constants()]
  AlignedFloats residual_;      // halved; empty in the last layer
  AlignedFloats residual_bias_;
  AlignedFloats skip_;
};

/// The output head. The mean over the layers and the biases of their skips are part of its first
/// convolution.
struct PackedHead {
  explicit PackedHead(const GatedStackWeights& weights);

  AlignedFloats first_weight, first_bias;
  AlignedFloats second_weight, second_bias;
};

}  // namespace earpoint::kernels
