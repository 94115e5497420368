#pragma once

#include <cstdint>
#include <map>
#include <string>

#include <ATen/core/Tensor.h>

namespace earpoint {

/// Adam without weight decay, beta 0.9 and 0.999, epsilon 1e-8.
/// Source: Kingma and Ba, ICLR 2015, algorithm 1.
class Adam {
 public:
  /// @param parameters  share their memory with the network's
  explicit Adam(std::map<std::string, at::Tensor> parameters);

  /// Moves every parameter against its gradient; those without one stay.
  void step(double learning_rate);

  [[nodiscard]] std::int64_t steps() const { return steps_; }
  /// Running means of the gradients and of their squares, by parameter.
  [[nodiscard]] const std::map<std::string, at::Tensor>& first_moments() const { return first_; }
  [[nodiscard]] const std::map<std::string, at::Tensor>& second_moments() const { return second_; }

  /// Goes on from there. The maps hold a tensor of each parameter's name and shape.
  void restore(std::int64_t steps, std::map<std::string, at::Tensor> first,
               std::map<std::string, at::Tensor> second);

 private:
  std::map<std::string, at::Tensor> parameters_;
  std::map<std::string, at::Tensor> first_;
  std::map<std::string, at::Tensor> second_;
  std::int64_t steps_ = 0;
};

}  // namespace earpoint
