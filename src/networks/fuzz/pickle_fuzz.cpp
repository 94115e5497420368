#include <cstdint>
#include <cstdlib>
#include <string>

#include <earpoint/error.h>
#include <earpoint/vigas/weights.h>
#include <earpoint/weights/checkpoint.h>
#include <earpoint/weights_testing/checkpoint_bytes.h>

/// Any bytes as the pickle of an otherwise sound checkpoint with two storages.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace earpoint;  // NOLINT(google-build-using-namespace): one function
  const std::string pickle(reinterpret_cast<const char*>(data), size);
  const auto archive = testing_bytes::zipped({{"a/data.pkl", pickle},
                                              {"a/data/0", std::string(24, '\0')},
                                              {"a/data/1", std::string(64, '\1')}});
  try {
    Checkpoint checkpoint = parse_checkpoint(archive, "input");
    for (const auto& [name, tensor] : checkpoint.state_dict) {
      const auto claimed = static_cast<std::size_t>(tensor.elements()) * size_of(tensor.dtype);
      if (tensor.data.size() != claimed) std::abort();
    }
    (void)weight_file_from_checkpoint(std::move(checkpoint), KeepTensors::all, "input");
  } catch (const InputError&) {
    return 0;
  }
  return 0;
}
