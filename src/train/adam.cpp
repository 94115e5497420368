#include "adam.h"

#include <cmath>
#include <utility>

#include <ATen/core/grad_mode.h>
#include <ATen/ops/zeros_like.h>

#include <earpoint/core/error.h>

namespace earpoint {
namespace {

constexpr double kFirstDecay = 0.9;
constexpr double kSecondDecay = 0.999;
constexpr double kEpsilon = 1e-8;

}  // namespace

Adam::Adam(std::map<std::string, at::Tensor> parameters) : parameters_(std::move(parameters)) {
  for (const auto& [name, parameter] : parameters_) {
    first_[name] = at::zeros_like(parameter);
    second_[name] = at::zeros_like(parameter);
  }
}

void Adam::step(double learning_rate) {
  const at::NoGradGuard no_gradients;
  ++steps_;
  const double count = static_cast<double>(steps_);
  const double first_bias = 1.0 - std::pow(kFirstDecay, count);
  const double second_bias = 1.0 - std::pow(kSecondDecay, count);
  for (auto& [name, parameter] : parameters_) {
    const at::Tensor gradient = parameter.grad();
    if (!gradient.defined()) continue;
    at::Tensor& first = first_.at(name);
    at::Tensor& second = second_.at(name);
    first.mul_(kFirstDecay).add_(gradient, 1.0 - kFirstDecay);
    second.mul_(kSecondDecay).addcmul_(gradient, gradient, 1.0 - kSecondDecay);
    const at::Tensor scale = second.sqrt().div_(std::sqrt(second_bias)).add_(kEpsilon);
    parameter.addcdiv_(first, scale, -learning_rate / first_bias);
  }
}

void Adam::restore(std::int64_t steps, std::map<std::string, at::Tensor> first,
                   std::map<std::string, at::Tensor> second) {
  for (const auto& [name, parameter] : parameters_) {
    EARPOINT_CHECK(first.at(name).sizes() == parameter.sizes());
    EARPOINT_CHECK(second.at(name).sizes() == parameter.sizes());
  }
  steps_ = steps;
  first_ = std::move(first);
  second_ = std::move(second);
}

}  // namespace earpoint
