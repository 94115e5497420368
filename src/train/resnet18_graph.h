#pragma once

#include <map>
#include <string>

#include <ATen/core/Tensor.h>

#include <earpoint/model/tensor.h>

namespace earpoint {

/// Batch norm either follows its batch and learns running statistics, or uses those.
enum class GraphMode { training, evaluation };

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
};

/// @param name  of the layer: `<name>.weight`, `.bias`, `.running_mean` and `.running_var`
at::Tensor batch_norm(const GraphTensors& tensors, const std::string& name, const at::Tensor& x,
                      GraphMode mode);

/// ResNet-18 without pooling and classifier, of any width.
/// @param prefix   the network's names start with it
/// @param picture  [pictures][channels][height][width]
/// @return         [pictures][8 * width of the first stage][height / 32][width / 32], rounded up
/// Source: as infer's ResNet18.
at::Tensor resnet18(const GraphTensors& tensors, const std::string& prefix,
                    const at::Tensor& picture, GraphMode mode);

}  // namespace earpoint
