#pragma once

#include <map>
#include <string>

#include <ATen/core/Tensor.h>

#include <earpoint/model/tensor.h>

namespace earpoint {

/// A network's tensors under the names of its weight file.
struct GraphTensors {
  std::map<std::string, at::Tensor> parameters;  ///< what is learned by gradients
  std::map<std::string, at::Tensor> buffers;     ///< running statistics of batch norms

  GraphTensors() = default;
  /// Copies; the parameters ask for gradients.
  GraphTensors(const std::map<std::string, Tensor>& weights, const at::Device& device);

  [[nodiscard]] const at::Tensor& parameter(const std::string& name) const {
    return parameters.at(name);
  }
  /// Copies of all, as they are now.
  [[nodiscard]] std::map<std::string, Tensor> weights() const;
  /// Copies of the parameters' last gradients. @throws std::logic_error if one has none
  [[nodiscard]] std::map<std::string, Tensor> gradients() const;
};

/// Drops the gradients of the last step.
void forget_gradients(std::map<std::string, at::Tensor>& parameters);

}  // namespace earpoint
