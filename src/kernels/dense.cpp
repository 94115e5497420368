#include <earpoint/kernels/dense.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <earpoint/error.h>

namespace earpoint::kernels {

Dense::Dense(std::span<const float> weight, std::span<const float> bias)
    : inputs_(bias.empty() ? 0 : static_cast<int>(weight.size() / bias.size())),
      weight_(weight.size()),
      bias_(bias.begin(), bias.end()) {
  const std::size_t inputs = static_cast<std::size_t>(inputs_);
  EARPOINT_CHECK(weight.size() == inputs * bias.size());
  for (std::size_t out = 0; out < bias.size(); ++out) {
    for (std::size_t in = 0; in < inputs; ++in) {
      weight_[in * bias.size() + out] = weight[out * inputs + in];
    }
  }
}

void Dense::apply(std::span<const float> in, std::span<float> out) const {
  EARPOINT_CHECK(std::ssize(in) == inputs_ && out.size() == bias_.size());
  std::copy(bias_.begin(), bias_.end(), out.begin());
  const float* row = weight_.data();
  for (const float value : in) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += row[i] * value;
    row += out.size();
  }
}

void apply_relu(std::span<float> values) {
  for (float& value : values) value = std::max(value, 0.0F);
}

void silu(std::span<float> values) {
  for (float& x : values) x = x / (1.0F + std::exp(-x));
}

}  // namespace earpoint::kernels
