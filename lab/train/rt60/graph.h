#pragma once

#include "graph_tensors.h"
#include "resnet18_graph.h"
#include "stft_loss.h"

#include <ATen/core/Tensor.h>

#include <earpoint/rt60/description.h>
#include <earpoint/rt60/weights.h>

namespace earpoint {

/// What Rt60Estimator computes, with gradients by the weights and by the sound.
struct Rt60Graph {
  Rt60Graph(const Rt60EstimatorWeights& weights, const at::Device& device);

  /// Where a gradient by the sound is wanted, magnitudes stop at 3e-4, as at zero they have none.
  /// @param sounds  [sounds][Rt60Description::kWindowSamples]
  /// @return        [sounds], seconds
  [[nodiscard]] at::Tensor estimate_s(const at::Tensor& sounds, GraphMode mode) const;

  Rt60Description description;
  GraphTensors tensors;
  ShortTimeMagnitude magnitude;
};

/// How far the reverberation time of what is found is off, both as the estimator hears it, each
/// whole second of each ear for itself.
/// @param found, right  [clips][2][samples], at least a second
/// @return mean absolute difference, seconds
at::Tensor reverberation_error_s(const Rt60Graph& estimator, const at::Tensor& found,
                                 const at::Tensor& right);

}  // namespace earpoint
