#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace earpoint {

/// Height and width in pixels of the pictures that an ONNX network takes.
struct OnnxInput {
  int height = 0;
  int width = 0;
};

/// Reads the shape [1][3][height][width] of a network's first input of four axes; OpenCV's importer
/// keeps it to itself.
/// @param bytes  an ONNX file: ModelProto in protobuf's encoding
/// @return nothing where a side is left open
/// @throws InputError if the file is no such thing, or takes no picture of three channels
[[nodiscard]] std::optional<OnnxInput> onnx_input(std::span<const std::byte> bytes,
                                                  std::string_view where);

}  // namespace earpoint
