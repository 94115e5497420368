#pragma once

#include "adam.h"
#include "graph_tensors.h"

#include <map>
#include <optional>
#include <string>
#include <utility>

#include <ATen/core/Tensor.h>

namespace earpoint {

/// What a GradientLearner works on. The tensors share their memory with the graph's.
struct LearnedTensors {
  /// The network's parameters, and the statistics that its batch norms keep.
  GraphTensors network;
  /// Tensors of the network that training leaves as they are.
  std::map<std::string, at::Tensor> tables;
  /// What the optimizer moves: the network's parameters, and what learns beside them.
  std::map<std::string, at::Tensor> parameters;
  Adam adam;
  /// Gradients of one step are scaled down together to that length.
  std::optional<double> longest_gradient;

  /// @param beside  what learns beside the network and is no part of it
  explicit LearnedTensors(GraphTensors tensors, std::map<std::string, at::Tensor> beside = {},
                          AdamDecay decay = {})
      : network(std::move(tensors)),
        parameters(together(network.parameters, std::move(beside))),
        adam(parameters, decay) {}

 private:
  [[nodiscard]] static std::map<std::string, at::Tensor> together(
      const std::map<std::string, at::Tensor>& some, std::map<std::string, at::Tensor> others) {
    others.insert(some.begin(), some.end());
    return others;
  }
};

}  // namespace earpoint
