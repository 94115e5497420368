#pragma once

#include "resnet18_graph.h"
#include "stack_graph.h"

#include <map>
#include <string>
#include <vector>

#include <ATen/core/Tensor.h>

#include <earpoint/vigas/description.h>
#include <earpoint/vigas/weights.h>

namespace earpoint {

/// What a network is given, as LibTorch tensors with the clips along the first axis.
struct GraphInputs {
  at::Tensor source;   ///< [clips][audio channels][samples]
  at::Tensor picture;  ///< [clips][3][height][width]; undefined without an image encoder
  std::map<std::string, at::Tensor> values;  ///< [clips][width], all inputs that are not made here
};

/// How the audio core is computed: by our own kernels, where they are to be had (float32 on the
/// processor), or by LibTorch's operations anywhere.
enum class StackKind { fused, operations };

/// The ViGAS network as a graph of LibTorch operations over named tensors: the names are those of
/// its weight file.
class ViGasGraph {
 public:
  ViGasGraph(const ViGasWeights& weights, const at::Device& device);

  /// @return [clips][audio channels][samples]; keeps what a gradient needs unless gradients are off
  /// @see StackGraph::forward() for when the gradient is available
  at::Tensor forward(const GraphInputs& inputs, GraphMode mode, StackKind kind = StackKind::fused) {
    return synthesize(inputs.source, fuse(inputs, mode), kind);
  }

  /// The first half of forward(): what the network makes of picture, pose and box.
  /// @return z: [clips][conditioning width]
  at::Tensor fuse(const GraphInputs& inputs, GraphMode mode);
  /// The second half: the gated stack.
  at::Tensor synthesize(const at::Tensor& source, const at::Tensor& fused,
                        StackKind kind = StackKind::fused);

  [[nodiscard]] const ViGasDescription& description() const { return description_; }
  /// What is learned by gradients.
  [[nodiscard]] std::map<std::string, at::Tensor>& parameters() { return tensors_.parameters; }
  [[nodiscard]] const GraphTensors& tensors() const { return tensors_; }

 private:
  at::Tensor image_feature(const at::Tensor& picture, GraphMode mode);
  at::Tensor operations(const at::Tensor& source, const at::Tensor& fused);
  at::Tensor gate(int layer, const at::Tensor& x, const at::Tensor& fused);
  at::Tensor pointwise(const std::string& name, const at::Tensor& x);
  const at::Tensor& parameter(const std::string& name) const { return tensors_.parameter(name); }

  ViGasDescription description_;
  GraphTensors tensors_;
  StackGraph stack_;
};

}  // namespace earpoint
