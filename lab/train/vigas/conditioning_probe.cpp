#include "conditioning_probe.h"

#include "torch_tensor.h"

#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/linear.h>
#include <ATen/ops/zeros.h>

namespace earpoint {
namespace {

constexpr const char* kWeight = "conditioning_probe.weight";
constexpr const char* kBias = "conditioning_probe.bias";
/// Energy below which changes of level do not count: 60 dB below full scale.
constexpr double kQuietPower = 1e-6;

/// Natural logarithm of the ears' amplitudes: [clips][audio channels].
at::Tensor log_level(const at::Tensor& sound) {
  return (sound.square().mean(at::IntArrayRef({2})) + kQuietPower).log() / 2;
}

}  // namespace

ConditioningProbe::ConditioningProbe(std::int64_t conditioning_width, std::int64_t audio_channels,
                                     const at::Device& device) {
  const std::int64_t answers = kPlaceWidth + audio_channels;
  const at::TensorOptions options = at::TensorOptions(at::kFloat).device(device);
  parameters_[kWeight] = at::zeros({answers, conditioning_width}, options);
  parameters_[kBias] = at::zeros({answers}, options);
  for (auto& [name, parameter] : parameters_) parameter.set_requires_grad(true);
}

at::Tensor ConditioningProbe::error(const at::Tensor& fused, const at::Tensor& place,
                                    const at::Tensor& source, const at::Tensor& target) const {
  const at::Tensor answer = at::linear(fused, parameters_.at(kWeight), parameters_.at(kBias));
  const at::Tensor truth = at::cat({place, log_level(target) - log_level(source)}, 1);
  return (answer - truth).square().mean(at::IntArrayRef({0})).sum();
}

void ConditioningProbe::save(SafetensorsFile& file) const {
  for (const auto& [name, parameter] : parameters_) file.tensors[name] = from_torch(parameter);
}

void ConditioningProbe::load(const SafetensorsFile& file, std::string_view where) {
  const at::NoGradGuard no_gradients;
  for (auto& [name, parameter] : parameters_) {
    parameter.copy_(saved_tensor(file, where, name, parameter));
  }
}

}  // namespace earpoint
