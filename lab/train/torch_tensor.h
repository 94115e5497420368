#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <ATen/core/Tensor.h>

#include <earpoint/weights/safetensors.h>
#include <earpoint/weights/tensor.h>

namespace earpoint {

/// @param name  as LibTorch calls it: "cpu", "cuda", "cuda:1"
/// @throws InputError if LibTorch does not have it here
at::Device device_named(const std::string& name);

/// A LibTorch tensor that holds a copy of the values, on `device`.
/// @param values  row-major, as many as `shape` has elements
at::Tensor to_torch(std::span<const float> values, const std::vector<std::int64_t>& shape,
                    const at::Device& device);
at::Tensor to_torch(const Tensor& tensor, const at::Device& device);

/// What training saved beside the weights. @param where  the file, for messages
/// @return a copy on the device of `like`
/// @throws InputError if the file has no float32 tensor of that name and the shape of `like`
at::Tensor saved_tensor(const SafetensorsFile& file, std::string_view where,
                        const std::string& name, const at::Tensor& like);

/// A copy in memory of a float32 tensor, wherever it lies.
Tensor from_torch(const at::Tensor& tensor);

/// The numbers of a float32 tensor, row-major.
template <typename Number>
std::vector<Number> numbers_of(const at::Tensor& tensor) {
  const Tensor copy = from_torch(tensor);
  const auto values = copy.as<float>();
  return {values.begin(), values.end()};
}

/// The sounds of a batch. @param values  planar, clip after clip, of equal length
/// @return [clips][channels][samples]
at::Tensor sounds_to_torch(const std::vector<float>& values, std::int64_t clips,
                           std::int64_t channels, const at::Device& device);

}  // namespace earpoint
