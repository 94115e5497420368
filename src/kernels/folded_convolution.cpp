#include <earpoint/kernels/folded_convolution.h>

#include <cmath>
#include <cstddef>

#include <earpoint/kernels/norms.h>

namespace earpoint::kernels {

FoldedConvolution fold_batch_norm(const TensorByName& tensor, const std::string& convolution,
                                  const std::string& norm, bool has_bias) {
  const Tensor& weight = tensor(convolution + ".weight");
  const auto values = weight.as<float>();
  const auto gain = tensor(norm + ".weight").as<float>();
  const auto offset = tensor(norm + ".bias").as<float>();
  const auto mean = tensor(norm + ".running_mean").as<float>();
  const auto variance = tensor(norm + ".running_var").as<float>();
  FoldedConvolution folded;
  const std::size_t size = values.size() / gain.size();
  for (std::size_t out = 0; out < gain.size(); ++out) {
    const double scale = gain[out] / std::sqrt(variance[out] + kBatchNormEpsilon);
    for (std::size_t i = 0; i < size; ++i) {
      folded.weight.push_back(static_cast<float>(scale * values[out * size + i]));
    }
    const double bias = has_bias ? tensor(convolution + ".bias").as<float>()[out] : 0.0;
    folded.bias.push_back(static_cast<float>(offset[out] + scale * (bias - mean[out])));
  }
  return folded;
}

FoldedConvolution plain_convolution(const TensorByName& tensor, const std::string& convolution) {
  const auto weight = tensor(convolution + ".weight").as<float>();
  const auto bias = tensor(convolution + ".bias").as<float>();
  return {{weight.begin(), weight.end()}, {bias.begin(), bias.end()}};
}

}  // namespace earpoint::kernels
