#include "torch_tensor.h"

#include <algorithm>

#include <ATen/ops/empty.h>
#include <ATen/ops/zeros.h>
#include <c10/util/Exception.h>
#include <fmt/format.h>

#include <earpoint/error.h>

namespace earpoint {

at::Device device_named(const std::string& name) {
  try {
    const at::Device device(name);
    // Fails if LibTorch was built without this device or the machine has none.
    static_cast<void>(at::zeros({1}, at::TensorOptions().device(device)));
    return device;
  } catch (const c10::Error&) {
    throw InputError("device " + name, "LibTorch has no such device here", "use cpu");
  }
}

at::Tensor to_torch(std::span<const float> values, const std::vector<std::int64_t>& shape,
                    const at::Device& device) {
  EARPOINT_CHECK(element_count(shape) == static_cast<std::int64_t>(values.size()));
  at::Tensor tensor = at::empty(shape, at::TensorOptions().dtype(at::kFloat));
  std::copy(values.begin(), values.end(), tensor.data_ptr<float>());
  return tensor.to(device);
}

at::Tensor to_torch(const Tensor& tensor, const at::Device& device) {
  return to_torch(tensor.as<float>(), tensor.shape, device);
}

at::Tensor saved_tensor(const SafetensorsFile& file, std::string_view where,
                        const std::string& name, const at::Tensor& like) {
  const auto found = file.tensors.find(name);
  if (found == file.tensors.end() || found->second.dtype != DType::f32 ||
      at::IntArrayRef(found->second.shape) != like.sizes()) {
    throw InputError(where,
                     fmt::format("has no tensor '{}' of type F32 and shape {}", name,
                                 to_string(like.sizes().vec())),
                     "was it written by training with this configuration?");
  }
  return to_torch(found->second, like.device());
}

Tensor from_torch(const at::Tensor& tensor) {
  const at::Tensor here = tensor.detach().to(at::kCPU).contiguous();
  const std::span<const float> values(here.data_ptr<float>(),
                                      static_cast<std::size_t>(here.numel()));
  return make_tensor<float>(values, here.sizes().vec());
}

at::Tensor sounds_to_torch(const std::vector<float>& values, std::int64_t clips,
                           std::int64_t channels, const at::Device& device) {
  EARPOINT_CHECK(clips > 0 && !values.empty());
  const auto samples = static_cast<std::int64_t>(values.size()) / (clips * channels);
  return to_torch(values, {clips, channels, samples}, device);
}

}  // namespace earpoint
