#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/weights/tensor.h>

namespace earpoint {

/// One tensor as a safetensors header describes it.
struct SafetensorsEntry {
  DType dtype = DType::f32;
  std::vector<std::int64_t> shape;
  std::int64_t begin = 0;  ///< bytes from the start of the data
  std::int64_t end = 0;
};

struct SafetensorsHeader {
  std::map<std::string, SafetensorsEntry> entries;
  std::map<std::string, std::string> metadata;
};

/// Reads and checks the JSON header, each entry by itself and all against the data's size.
/// @param text       the header without its length, with its padding
/// @param data_size  bytes that follow the header
/// @param where      the file, for messages
/// @throws InputError
SafetensorsHeader parse_safetensors_header(std::string_view text, std::int64_t data_size,
                                           std::string_view where);

}  // namespace earpoint
