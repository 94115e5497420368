#include <cstdint>
#include <cstdlib>
#include <span>

#include <earpoint/error.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/network/network_kind.h>
#include <earpoint/people/weights.h>
#include <earpoint/rt60/weights.h>
#include <earpoint/vam/weights.h>
#include <earpoint/vigas/weights.h>
#include <earpoint/weights/safetensors.h>

/// Any bytes as a weight file: refused with InputError, or read, and then what is written back must
/// read the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace earpoint;  // NOLINT(google-build-using-namespace): one function
  try {
    const auto bytes = std::as_bytes(std::span(data, size));
    SafetensorsFile file = parse_safetensors(bytes, "input");
    const SafetensorsFile again = parse_safetensors(serialize_safetensors(file, "copy"), "copy");
    if (again.tensors != file.tensors || again.metadata != file.metadata) std::abort();
    switch (network_kind(file, "input")) {
      case NetworkKind::vigas:
        (void)vigas_weights(std::move(file), "input");
        break;
      case NetworkKind::gtf:
        (void)gtf_weights(std::move(file), "input");
        break;
      case NetworkKind::rt60_estimator:
        (void)rt60_estimator_weights(std::move(file), "input");
        break;
      case NetworkKind::vam:
        (void)vam_weights(std::move(file), "input");
        break;
      case NetworkKind::people:
        (void)people_weights(std::move(file), "input");
        break;
    }
  } catch (const InputError&) {
    return 0;
  }
  return 0;
}
