#pragma once

#include <map>
#include <string>

#include <ATen/core/Tensor.h>

#include <earpoint/train/learner.h>
#include <earpoint/weights/tensor.h>

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
  /// Copies of the parameters' last gradients; zeros of those that have none.
  [[nodiscard]] std::map<std::string, Tensor> gradients() const;
};

/// Drops the gradients of the last step.
void forget_gradients(std::map<std::string, at::Tensor>& parameters);

/// Shows the values of every tensor, in the order of names. @see Learner::Visitor
void visit_values(const std::map<std::string, at::Tensor>& tensors,
                  const Learner::Visitor& visitor);

/// The same of the tensors' gradients, of those that have one.
void visit_gradients(const std::map<std::string, at::Tensor>& parameters,
                     const Learner::Visitor& visitor);

}  // namespace earpoint
