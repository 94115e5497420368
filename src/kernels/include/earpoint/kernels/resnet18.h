#pragma once

#include <memory>
#include <span>
#include <string>

#include <earpoint/kernels/folded_convolution.h>

namespace earpoint::kernels {

/// ResNet-18 without pooling and classifier, for inference; oneDNN does the work.
/// Source: He et al., Deep Residual Learning (2015); names and layout as in
/// docs/released-code.md, image trunk.
class ResNet18 {
 public:
  /// @param tensor   of the state dict; the network's names start with `prefix`
  /// @param channels of the picture, height and width in pixels
  /// @param threads  > 0
  ResNet18(const TensorByName& tensor, const std::string& prefix, int channels, int height,
           int width, int threads);
  ~ResNet18();
  ResNet18(ResNet18&&) noexcept;
  ResNet18& operator=(ResNet18&&) noexcept;

  /// Size of the map: a 32nd of the picture's, rounded up.
  [[nodiscard]] int map_height() const;
  [[nodiscard]] int map_width() const;
  /// Of the map, as the tensors have it.
  [[nodiscard]] int channels() const;

  /// @param picture  [channels][height][width]
  /// @param map      [channels()][map_height][map_width]
  void run(std::span<const float> picture, std::span<float> map);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint::kernels
