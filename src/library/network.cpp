#include <earpoint/network.h>

#include <utility>

#include <earpoint/error.h>
#include <earpoint/network/checked_tensors.h>
#include <earpoint/network/model_names.h>
#include <earpoint/network/network_kind.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {
namespace {

std::int64_t count_numbers(const SafetensorsFile& file) {
  std::int64_t count = 0;
  for (const auto& [name, tensor] : file.tensors) count += tensor.elements();
  return count;
}

}  // namespace

std::vector<std::string> installed_networks() { return shipped_model_names(); }

NetworkInfo describe_network(const std::string& model) {
  const auto file = find_model(model);
  if (!file) {
    throw InputError(model, "is neither the name of an installed model nor a weight file",
                     "set EARPOINT_MODELS_DIR to the folder that holds it, or give its path");
  }
  const SafetensorsFile weights = read_safetensors(*file);
  const NetworkKind kind = network_kind(weights, file->string());
  const bool renders =
      kind == NetworkKind::gtf || kind == NetworkKind::vigas || kind == NetworkKind::vam;
  return {.file = *file,
          .kind = std::string(name_of(kind)),
          .description = description_of(weights, file->string()),
          .parameters = count_numbers(weights),
          .renders = renders,
          .streams = kind == NetworkKind::gtf};
}

}  // namespace earpoint
