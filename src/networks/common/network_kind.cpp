#include <earpoint/network/network_kind.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/quote.h>
#include <earpoint/core/strict_json.h>
#include <earpoint/error.h>
#include <earpoint/network/checked_tensors.h>

namespace earpoint {
namespace {

constexpr std::array<std::pair<std::string_view, NetworkKind>, 5> kKinds{
    {{"vigas", NetworkKind::vigas},
     {"gtf", NetworkKind::gtf},
     {"vam", NetworkKind::vam},
     {"rt60_estimator", NetworkKind::rt60_estimator},
     {"people", NetworkKind::people}}};

}  // namespace

std::string_view name_of(NetworkKind kind) {
  const auto* found =
      std::ranges::find(kKinds, kind, &std::pair<std::string_view, NetworkKind>::second);
  EARPOINT_CHECK(found != kKinds.end());
  return found->first;
}

NetworkKind network_kind(const SafetensorsFile& file, std::string_view where) {
  constexpr int kDepth = 3;
  const std::string here = where_described(where);
  const nlohmann::json json = parse_strict_json(description_of(file, where), here, kDepth);
  const std::string network = JsonObjectReader(json, here).string("network");
  for (const auto& [name, kind] : kKinds) {
    if (network == name) return kind;
  }
  throw InputError(
      here, fmt::format("'network': expected 'vigas', 'gtf', 'vam', 'rt60_estimator' or 'people', "
                        "found {}",
                        in_quotes(network)));
}

}  // namespace earpoint
