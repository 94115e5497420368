#pragma once

#include <span>
#include <vector>

#include <earpoint/kernels/dense.h>
#include <earpoint/kernels/resnet18.h>
#include <earpoint/vigas/weights.h>

namespace earpoint {

/// From a picture to `visual_feat`: ResNet-18, 1x1 convolution, ReLU, flattened.
/// Source: docs/released-code.md, image trunk.
class ImageTrunk {
 public:
  /// @param weights  of a network with an image encoder
  ImageTrunk(const ViGasWeights& weights, int threads);

  /// @param picture  [3][height][width], 0 to 1
  /// @param feature  [channels][map height][map width]
  void encode(std::span<const float> picture, std::span<float> feature);

  /// What the ResNet made of the last picture: [8 * trunk_channels][map height][map width].
  [[nodiscard]] std::span<const float> map() const { return map_; }

 private:
  kernels::ResNet18 resnet_;
  kernels::Dense reduction_;
  std::vector<float> map_;
  std::vector<float> pixel_;
  std::vector<float> reduced_;
};

}  // namespace earpoint
