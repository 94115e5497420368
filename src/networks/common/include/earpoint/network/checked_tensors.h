#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/weights/safetensors.h>
#include <earpoint/weights/tensor.h>

namespace earpoint {

/// Key in a weight file's metadata: the network's description as JSON.
inline constexpr std::string_view kDescriptionKey = "earpoint.network";

using NamedTensors = std::map<std::string, Tensor>;
using TensorShapes = std::map<std::string, std::vector<std::int64_t>>;

/// The network's description in a weight file's metadata.
/// @param where  the file, for messages
/// @throws InputError if it has none
const std::string& description_of(const SafetensorsFile& file, std::string_view where);

/// `where`, and which of the metadata.
std::string where_described(std::string_view where);

/// Moves the required tensors out of `from`, checked and widened to float32; what stays is not read
/// by inference.
/// @throws InputError if one is missing, of another shape, not of floating point, or not finite
NamedTensors take_required(NamedTensors& from, const TensorShapes& shapes, std::string_view where);

std::vector<std::string> names_of(const NamedTensors& tensors);

/// @throws std::logic_error if there is none of that name
const Tensor& tensor_at(const NamedTensors& tensors, const std::string& name);

}  // namespace earpoint
