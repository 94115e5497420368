#pragma once

#include "graph_tensors.h"
#include "resnet18_graph.h"

#include <ATen/core/Tensor.h>

#include <earpoint/people/description.h>
#include <earpoint/people/weights.h>

namespace earpoint {

/// What PeopleNetwork computes, with gradients by the weights.
struct PeopleGraph {
  PeopleGraph(const PeopleWeights& weights, const at::Device& device);

  /// @param views  [pictures][3][height][width], sides multiples of PeopleDescription::kCoarsest
  /// @return       [pictures][PeopleDescription::kOutputs][height / kCell][width / kCell]
  [[nodiscard]] at::Tensor run(const at::Tensor& views, GraphMode mode) const;

  PeopleDescription description;
  GraphTensors tensors;
};

}  // namespace earpoint
