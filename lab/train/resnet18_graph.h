#pragma once

#include "graph_tensors.h"

#include <string>

#include <ATen/core/Tensor.h>

namespace earpoint {

/// Batch norm either follows its batch and learns running statistics, or uses those.
enum class GraphMode { training, evaluation };

/// @param name  of the layer: `<name>.weight`, `.bias`, `.running_mean` and `.running_var`
at::Tensor batch_norm(const GraphTensors& tensors, const std::string& name, const at::Tensor& x,
                      GraphMode mode);

/// Two 3x3 convolutions with batch norms beside an identity or, where it halves, a 1x1 convolution.
/// @param name  of the block: `<name>.conv1.weight`, `.bn1`, ...
at::Tensor residual_block(const GraphTensors& tensors, const std::string& name, const at::Tensor& x,
                          bool halves, GraphMode mode);

/// ResNet-18 without pooling and classifier, of any width.
/// @param prefix   the network's names start with it
/// @param picture  [pictures][channels][height][width]
/// @return         [pictures][8 * width of the first stage][height / 32][width / 32], rounded up
/// Source: as kernels::ResNet18.
at::Tensor resnet18(const GraphTensors& tensors, const std::string& prefix,
                    const at::Tensor& picture, GraphMode mode);

}  // namespace earpoint
