#include "graph_tensors.h"

#include "torch_tensor.h"

#include <ATen/core/grad_mode.h>
#include <ATen/ops/zeros_like.h>

namespace earpoint {
namespace {

/// If the tensor is not contiguous or not in CPU memory, the visitor gets a copy.
void visit(const at::Tensor& tensor, const Learner::Visitor& visitor) {
  const at::NoGradGuard no_gradients;
  const at::Tensor values = tensor.to(at::kCPU).contiguous();
  visitor({values.data_ptr<float>(), static_cast<std::size_t>(values.numel())});
  if (!values.is_same(tensor)) tensor.copy_(values);
}

}  // namespace

GraphTensors::GraphTensors(const std::map<std::string, Tensor>& weights, const at::Device& device) {
  for (const auto& [name, tensor] : weights) {
    at::Tensor values = to_torch(tensor, device);
    if (name.find(".running_") != std::string::npos) {
      buffers[name] = values;
    } else {
      parameters[name] = values.set_requires_grad(true);
    }
  }
}

std::map<std::string, Tensor> GraphTensors::weights() const {
  std::map<std::string, Tensor> weights;
  for (const auto& [name, tensor] : parameters) weights[name] = from_torch(tensor);
  for (const auto& [name, tensor] : buffers) weights[name] = from_torch(tensor);
  return weights;
}

std::map<std::string, Tensor> GraphTensors::gradients() const {
  std::map<std::string, Tensor> gradients;
  for (const auto& [name, parameter] : parameters) {
    const at::Tensor& gradient = parameter.grad();
    gradients[name] = from_torch(gradient.defined() ? gradient : at::zeros_like(parameter));
  }
  return gradients;
}

void forget_gradients(std::map<std::string, at::Tensor>& parameters) {
  for (auto& [name, parameter] : parameters) parameter.mutable_grad().reset();
}

void visit_values(const std::map<std::string, at::Tensor>& tensors,
                  const Learner::Visitor& visitor) {
  for (const auto& [name, tensor] : tensors) visit(tensor, visitor);
}

void visit_gradients(const std::map<std::string, at::Tensor>& parameters,
                     const Learner::Visitor& visitor) {
  for (const auto& [name, parameter] : parameters) {
    if (parameter.grad().defined()) visit(parameter.grad(), visitor);
  }
}

}  // namespace earpoint
