#include <earpoint/network_testing/random_weights.h>

#include <algorithm>
#include <cstddef>

#include <earpoint/error.h>

namespace earpoint {
namespace {

Tensor random_tensor(const std::vector<std::int64_t>& shape, RandomStream& random, double low,
                     double high) {
  std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()));
  for (float& value : values) value = static_cast<float>(random.uniform(low, high));
  return make_tensor<float>(values, shape);
}

}  // namespace

std::map<std::string, Tensor> random_tensors(
    const std::map<std::string, std::vector<std::int64_t>>& shapes, RandomStream& random,
    double low, double high) {
  std::map<std::string, Tensor> tensors;
  for (const auto& [name, shape] : shapes) {
    tensors[name] = random_tensor(shape, random, low, high);
  }
  return tensors;
}

GtfWeights random_gtf_weights(const GtfDescription& description) {
  GtfWeights weights{description, {}, {}};
  RandomStream random(1);
  for (const auto& [name, shape] : required_tensors(description)) {
    const double low = name.find("power") != std::string::npos ? 0.5 : -0.2;
    weights.tensors[name] = random_tensor(shape, random, low, low + 0.4);
  }
  return weights;
}

GtfWeights pass_through_gtf_weights(const GtfDescription& description) {
  EARPOINT_CHECK(!description.delays);
  GtfWeights weights = random_gtf_weights(description);
  for (const auto& [name, shape] : required_tensors(description)) {
    if (is_gtf_table(name)) continue;
    std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()));
    if (name == "kernel.bias") {
      // [out ear][in ear][tap][band]
      for (int ear = 0; ear < 2; ++ear) {
        const std::ptrdiff_t row =
            (std::ptrdiff_t{ear} * 2 + ear) * description.taps() + description.past_frames;
        std::fill_n(values.begin() + row * description.bands, description.bands, 1.0F);
      }
    }
    weights.tensors[name] = make_tensor<float>(values, shape);
  }
  return weights;
}

}  // namespace earpoint
