#include "onnx_input.h"

#include <cstdint>
#include <cstdlib>

#include <earpoint/error.h>

/// Any bytes as an ONNX file: refused with InputError, or its input has a size.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace earpoint;  // NOLINT(google-build-using-namespace): one function
  try {
    const auto input = onnx_input(std::as_bytes(std::span(data, size)), "input");
    if (input && (input->height <= 0 || input->width <= 0)) std::abort();
  } catch (const InputError&) {
    return 0;
  }
  return 0;
}
