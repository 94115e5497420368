#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/weights/tensor.h>

namespace earpoint {

/// What a .safetensors file holds.
/// Source: the format's description, https://github.com/huggingface/safetensors (README).
struct SafetensorsFile {
  std::map<std::string, Tensor> tensors;
  std::map<std::string, std::string> metadata;  ///< the header's `__metadata__`
};

/// Reads a whole file and checks all of it: the header's length, its JSON and every key in it,
/// types, shapes, and that the tensors' bytes fill the rest of the file without gap or overlap.
/// Memory stays within a small multiple of the file's size whatever the file claims.
/// @throws InputError, naming the file and the tensor
[[nodiscard]] SafetensorsFile read_safetensors(const std::filesystem::path& path);

/// The same for bytes in memory.
/// @param where  stands for the file in messages
[[nodiscard]] SafetensorsFile parse_safetensors(std::span<const std::byte> bytes,
                                                std::string_view where);

/// Writes aside and renames. The same tensors and metadata give the same bytes: the header's keys
/// are sorted, it is padded with spaces to a multiple of 8, and the data follow in order of
/// falling element size, then name, so that every tensor is aligned.
/// @throws InputError if the file cannot be written, or a name is not UTF-8 or is "__metadata__"
/// @throws std::logic_error if a tensor's bytes do not fit its shape
void write_safetensors(const std::filesystem::path& path, const SafetensorsFile& file);

/// The bytes that write_safetensors writes.
/// @param where  stands for the file in messages
[[nodiscard]] std::vector<std::byte> serialize_safetensors(const SafetensorsFile& file,
                                                           std::string_view where);

/// The tensor of that name, after checking that it is there and what it is.
/// @param where  the file, for messages
/// @param shape  the expected sizes; kAnySize matches every size
/// @throws InputError naming file and tensor, what was expected and what was found
[[nodiscard]] const Tensor& expect_tensor(const SafetensorsFile& file, std::string_view where,
                                          const std::string& name, DType dtype,
                                          std::initializer_list<std::int64_t> shape);
inline constexpr std::int64_t kAnySize = -1;

}  // namespace earpoint
