#pragma once

#include "resnet18_graph.h"

#include <memory>

#include <ATen/core/Tensor.h>

#include <earpoint/vigas/description.h>

namespace earpoint {

/// The audio core of ViGAS as one node of a LibTorch graph, computed by kernels of our own
/// (FusedStack). Float32 on the processor only.
class StackGraph {
 public:
  explicit StackGraph(const ViGasDescription& description);
  ~StackGraph();
  StackGraph(StackGraph&&) noexcept;
  StackGraph& operator=(StackGraph&&) noexcept;

  /// Keeps what a gradient needs unless gradients are off, in memory that the next call takes
  /// again: the gradient of a result is available once, before that.
  /// @param tensors  by the names of the weight file
  /// @param source   [clips][audio channels][samples]; has no gradient
  /// @param fused    [clips][conditioning width]
  /// @return         shape of source
  at::Tensor forward(const GraphTensors& tensors, const at::Tensor& source,
                     const at::Tensor& fused);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
