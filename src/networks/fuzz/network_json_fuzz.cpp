#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <earpoint/error.h>
#include <earpoint/vigas/description.h>

/// Any text as a network's description: refused with InputError, or read, and then it round-trips
/// and names its tensors without overflow.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace earpoint;  // NOLINT(google-build-using-namespace): one function
  try {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const ViGasDescription description = vigas_description_from_json(text, "input");
    const std::string json = to_json(description);
    if (to_json(vigas_description_from_json(json, "copy")) != json) std::abort();
    for (const auto& [name, shape] : required_tensors(description)) {
      if (!element_count(shape)) std::abort();
    }
    (void)description.dilation(description.layers() - 1);
  } catch (const InputError&) {
    return 0;
  }
  return 0;
}
