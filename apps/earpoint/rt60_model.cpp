#include "rt60_model.h"

#include <earpoint/network/model_names.h>

namespace earpoint {

std::optional<std::filesystem::path> rt60_model(const std::filesystem::path& given) {
  if (!given.empty()) return given;
  return shipped_model("rt60");
}

}  // namespace earpoint
