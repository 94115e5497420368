#include <cstdint>
#include <cstdlib>
#include <span>

#include <earpoint/error.h>
#include <earpoint/vigas/weights.h>
#include <earpoint/weights/checkpoint.h>

/// Any bytes as a checkpoint file: this tests the reader of the zip archive; pickle_fuzz gets past
/// the archive's checksums.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace earpoint;  // NOLINT(google-build-using-namespace): one function
  try {
    Checkpoint checkpoint = parse_checkpoint(std::as_bytes(std::span(data, size)), "input");
    (void)weight_file_from_checkpoint(std::move(checkpoint), KeepTensors::all, "input");
  } catch (const InputError&) {
    return 0;
  }
  return 0;
}
