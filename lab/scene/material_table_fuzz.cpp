#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <earpoint/error.h>
#include <earpoint/scene/material_table.h>

/// Any text as a table of materials: refused with InputError, or read, and then every surface has a
/// sound whose shares of energy make sense.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace earpoint;  // NOLINT(google-build-using-namespace): one function
  try {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const MaterialTable table = MaterialTable::parse(text, "input");
    for (const AcousticMaterial& material : table.materials()) {
      if (table.find(material.name) == nullptr) std::abort();
      for (std::size_t band = 0; band < kOctaveBands; ++band) {
        const bool good = material.absorption[band] >= 0.0F && material.absorption[band] <= 1.0F &&
                          material.scattering[band] >= 0.0F && material.scattering[band] <= 1.0F &&
                          material.transmission[band] >= 0.0F &&
                          material.transmission[band] <= material.absorption[band];
        if (!good) std::abort();
      }
    }
    for (const std::string_view name : {text.substr(0, 64), std::string_view("Wall_03.Plaster")}) {
      if (table.match(name).material == nullptr) std::abort();
    }
  } catch (const InputError&) {
    return 0;
  }
  return 0;
}
