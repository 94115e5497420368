#include "sofa_contents.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>

#include <earpoint/error.h>

/// Any bytes as a message from the child process that reads SOFA files: refused with InputError, or
/// a set of responses that is whole and finite. sofa_fuzz runs the child too, which takes far more
/// time per input.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace earpoint;  // NOLINT(google-build-using-namespace): one function
  try {
    const std::span message(reinterpret_cast<const char*>(data), size);
    const SofaFile sofa = sofa_file_from_contents("input", parse_sofa_message(message, "input"));
    const std::size_t measurements = sofa.positions_m.size();
    if (sofa.delays_samples.size() != measurements ||
        sofa.responses.size() != measurements * 2 * static_cast<std::size_t>(sofa.taps)) {
      std::abort();
    }
    for (const float value : sofa.responses) {
      if (!std::isfinite(value)) std::abort();
    }
    for (const Vector3& position : sofa.positions_m) {
      if (!(norm(position) > 0.0) || !std::isfinite(norm(position))) std::abort();
    }
  } catch (const InputError&) {
    return 0;
  }
  return 0;
}
