#include <earpoint/network/network_kind.h>

#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/error.h>
#include <earpoint/core/quote.h>
#include <earpoint/core/strict_json.h>
#include <earpoint/network/checked_tensors.h>

namespace earpoint {

NetworkKind network_kind(const SafetensorsFile& file, std::string_view where) {
  constexpr int kDepth = 3;
  const std::string here = where_described(where);
  const nlohmann::json json = parse_strict_json(description_of(file, where), here, kDepth);
  const std::string network = JsonObjectReader(json, here).string("network");
  if (network == "vigas") return NetworkKind::vigas;
  if (network == "gtf") return NetworkKind::gtf;
  if (network == "rt60_estimator") return NetworkKind::rt60_estimator;
  if (network == "vam") return NetworkKind::vam;
  if (network == "people") return NetworkKind::people;
  throw InputError(
      here, fmt::format("'network': expected 'vigas', 'gtf', 'vam', 'rt60_estimator' or 'people', "
                        "found {}",
                        in_quotes(network)));
}

}  // namespace earpoint
