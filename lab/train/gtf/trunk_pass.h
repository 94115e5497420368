#pragma once

#include <cstdint>
#include <vector>

#include <ATen/core/Tensor.h>

namespace earpoint {

/// The trunk's parameters and what modulates it.
struct TrunkTensors {
  at::Tensor input_weight;          ///< [channels][features]
  at::Tensor input_bias;            ///< [channels]
  std::vector<at::Tensor> weights;  ///< of each layer, [channels][channels][3], the last tap is now
  std::vector<at::Tensor> biases;   ///< [channels]
  std::vector<at::Tensor> films;    ///< [clips][2 channels]: scale less one, and shift
  std::vector<std::int64_t> dilations;  ///< of each layer, frames
};

/// The trunk and its gradient, clip by clip: a dense layer of every frame, then layers
/// x + silu(film(causal dilated convolution of x)).
/// @param features  [clips][features][row], without gradient; rows as FrameExtent has them
/// @param frames    of the sound
/// @param ahead     frames that the trunk sees in advance; beyond the last it sees zeros
/// @return          [clips][channels][row]; what lies beyond the frames is of no meaning
at::Tensor trunk_pass(const TrunkTensors& tensors, const at::Tensor& features, std::int64_t frames,
                      std::int64_t ahead);

}  // namespace earpoint
