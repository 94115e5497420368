#pragma once

#include <span>
#include <vector>

namespace earpoint::kernels {

/// A linear layer for one vector at a time.
class Dense {
 public:
  Dense() = default;
  /// @param weight  [outputs][inputs]
  /// @param bias    [outputs]
  Dense(std::span<const float> weight, std::span<const float> bias);

  [[nodiscard]] int inputs() const { return inputs_; }
  [[nodiscard]] int outputs() const { return static_cast<int>(bias_.size()); }

  /// out = weight * in + bias. Allocates nothing.
  void apply(std::span<const float> in, std::span<float> out) const;

 private:
  int inputs_ = 0;
  std::vector<float> weight_;  // [inputs][outputs]: the sums of all outputs advance side by side
  std::vector<float> bias_;
};

/// Negative values become zero.
void apply_relu(std::span<float> values);

/// x * sigmoid(x).
void silu(std::span<float> values);

}  // namespace earpoint::kernels
