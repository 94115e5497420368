#pragma once

#include <functional>
#include <string>
#include <vector>

#include <earpoint/weights/tensor.h>

namespace earpoint::kernels {

/// A convolution with the batch normalisation behind it folded in.
struct FoldedConvolution {
  std::vector<float> weight;  ///< [out][in][height][width]
  std::vector<float> bias;    ///< [out]
};

/// Tensor of a name in the state dict.
using TensorByName = std::function<const Tensor&(const std::string&)>;

/// Folds `<norm>.weight`, `.bias`, `.running_mean` and `.running_var` (eps 1e-5) into
/// `<convolution>.weight` and, if it has one, `<convolution>.bias`.
[[nodiscard]] FoldedConvolution fold_batch_norm(const TensorByName& tensor,
                                                const std::string& convolution,
                                                const std::string& norm, bool has_bias);

/// `<convolution>.weight` and `.bias` as they are.
[[nodiscard]] FoldedConvolution plain_convolution(const TensorByName& tensor,
                                                  const std::string& convolution);

}  // namespace earpoint::kernels
