#pragma once

#include "resnet18_graph.h"

#include <string>

#include <ATen/core/Tensor.h>

#include <earpoint/vam/description.h>
#include <earpoint/vam/weights.h>

namespace earpoint {

/// The visual acoustic matching network as a graph of LibTorch operations over named tensors.
class VamGraph {
 public:
  VamGraph(const VamWeights& weights, const at::Device& device);

  /// @param source   [clips][audio channels][samples]; zeros follow it up to a whole token
  /// @param picture  [clips][3][height][width]
  /// @param pose     [clips][VamDescription::kPoseWidth]
  /// @return         the shape of `source`
  at::Tensor forward(const at::Tensor& source, const at::Tensor& picture, const at::Tensor& pose,
                     GraphMode mode);

  [[nodiscard]] const VamDescription& description() const { return description_; }
  [[nodiscard]] GraphTensors& tensors() { return tensors_; }
  [[nodiscard]] const GraphTensors& tensors() const { return tensors_; }

 private:
  at::Tensor layer(const std::string& name, const at::Tensor& x) const;
  at::Tensor norm(const std::string& name, const at::Tensor& x) const;
  at::Tensor attend(const std::string& name, const at::Tensor& asking,
                    const at::Tensor& asked) const;
  at::Tensor convolve_tokens(const std::string& name, const at::Tensor& x) const;
  at::Tensor block(const std::string& name, const at::Tensor& x, const at::Tensor& image) const;
  at::Tensor fuse(const at::Tensor& deepest, const at::Tensor& map, const at::Tensor& pose) const;
  const at::Tensor& parameter(const std::string& name) const { return tensors_.parameter(name); }

  VamDescription description_;
  GraphTensors tensors_;
};

}  // namespace earpoint
