#include "adam.h"

#include "torch_tensor.h"

#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

#include <ATen/core/grad_mode.h>
#include <ATen/ops/zeros_like.h>
#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kEpsilon = 1e-8;

constexpr std::string_view kStepsKey = "earpoint.adam_steps";
constexpr std::string_view kFirst = "adam.first/";
constexpr std::string_view kSecond = "adam.second/";

std::map<std::string, at::Tensor> moments(const SafetensorsFile& file, std::string_view where,
                                          std::string_view prefix,
                                          const std::map<std::string, at::Tensor>& parameters) {
  std::map<std::string, at::Tensor> found;
  for (const auto& [name, parameter] : parameters) {
    found[name] = saved_tensor(file, where, std::string(prefix) + name, parameter);
  }
  return found;
}

std::string steps_key(const std::string& name) { return fmt::format("{}/{}", kStepsKey, name); }

std::int64_t steps_in(const SafetensorsFile& file, std::string_view where, const std::string& key) {
  const auto found = file.metadata.find(key);
  std::int64_t steps = -1;
  if (found != file.metadata.end()) {
    const std::string& text = found->second;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), steps);
    if (error != std::errc() || end != text.data() + text.size()) steps = -1;
  }
  if (steps < 0) {
    throw InputError(where, fmt::format("has no '{}' with the count of steps", key),
                     "was it written by training?");
  }
  return steps;
}

}  // namespace

Adam::Adam(std::map<std::string, at::Tensor> parameters, AdamDecay decay)
    : decay_(decay), parameters_(std::move(parameters)) {
  for (const auto& [name, parameter] : parameters_) {
    first_[name] = at::zeros_like(parameter);
    second_[name] = at::zeros_like(parameter);
    taken_[name] = 0;
  }
}

void Adam::step(double learning_rate) {
  const at::NoGradGuard no_gradients;
  ++steps_;
  for (auto& [name, parameter] : parameters_) {
    const at::Tensor gradient = parameter.grad();
    if (!gradient.defined()) continue;
    const auto count = static_cast<double>(++taken_.at(name));
    const double first_bias = 1.0 - std::pow(decay_.first, count);
    const double second_bias = 1.0 - std::pow(decay_.second, count);
    at::Tensor& first = first_.at(name);
    at::Tensor& second = second_.at(name);
    first.mul_(decay_.first).add_(gradient, 1.0 - decay_.first);
    second.mul_(decay_.second).addcmul_(gradient, gradient, 1.0 - decay_.second);
    const at::Tensor scale = second.sqrt().div_(std::sqrt(second_bias)).add_(kEpsilon);
    parameter.addcdiv_(first, scale, -learning_rate / first_bias);
  }
}

void Adam::save(SafetensorsFile& file) const {
  file.metadata[std::string(kStepsKey)] = std::to_string(steps_);
  for (const auto& [name, taken] : taken_) {
    if (taken != steps_) file.metadata[steps_key(name)] = std::to_string(taken);
  }
  for (const auto& [name, moment] : first_) {
    file.tensors[std::string(kFirst) + name] = from_torch(moment);
  }
  for (const auto& [name, moment] : second_) {
    file.tensors[std::string(kSecond) + name] = from_torch(moment);
  }
}

void Adam::load(const SafetensorsFile& file, std::string_view where) {
  const std::int64_t steps = steps_in(file, where, std::string(kStepsKey));
  std::map<std::string, std::int64_t> taken;
  for (const auto& [name, parameter] : parameters_) {
    const std::string key = steps_key(name);
    taken[name] = file.metadata.contains(key) ? steps_in(file, where, key) : steps;
  }
  std::map<std::string, at::Tensor> first = moments(file, where, kFirst, parameters_);
  second_ = moments(file, where, kSecond, parameters_);
  first_ = std::move(first);
  taken_ = std::move(taken);
  steps_ = steps;
}

double clip_gradients(const std::map<std::string, at::Tensor>& parameters, double longest) {
  const at::NoGradGuard no_gradients;
  double squares = 0.0;
  for (const auto& [name, parameter] : parameters) {
    if (parameter.grad().defined()) squares += parameter.grad().square().sum().item<double>();
  }
  const double length = std::sqrt(squares);
  if (length <= longest) return length;
  for (const auto& [name, parameter] : parameters) {
    if (parameter.grad().defined()) parameter.grad().mul_(longest / length);
  }
  return length;
}

}  // namespace earpoint
