#include <earpoint/network_testing/oracle_weights.h>

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15U;

std::uint64_t fnv1a64(std::string_view text) {
  std::uint64_t hash = 0xCBF29CE484222325U;
  for (const char c : text) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x100000001B3U;
  }
  return hash;
}

Tensor make_weights(const Json& entry, std::uint64_t seed) {
  auto shape = entry.at("shape").get<std::vector<std::int64_t>>();
  if (entry.contains("value")) {
    const std::vector<std::int64_t> value{entry.at("value").get<std::int64_t>()};
    return make_tensor<std::int64_t>(value, std::move(shape));
  }
  const OracleRandom random(entry.at("name").get<std::string>(), seed);
  const double lo = entry.at("lo").get<double>();
  const double hi = entry.at("hi").get<double>();
  std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = random.value(i, lo, hi);
  return make_tensor<float>(values, std::move(shape));
}

HyperParameter option_from(const Json& value) {
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_number_integer()) return value.get<std::int64_t>();
  if (value.is_number()) return value.get<double>();
  return value.get<std::string>();
}

}  // namespace

OracleRandom::OracleRandom(std::string_view tensor_name, std::uint64_t seed)
    : key_(fnv1a64(tensor_name) ^ (seed * kGolden)) {}

float OracleRandom::value(std::uint64_t index, double lo, double hi) const {
  std::uint64_t z = key_ + (index + 1) * kGolden;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  z ^= z >> 31U;
  return static_cast<float>(lo + (hi - lo) * (static_cast<double>(z >> 11U) * 0x1p-53));
}

Checkpoint make_oracle_checkpoint(const std::filesystem::path& manifest) {
  try {
    const Json json = Json::parse(read_text_file(manifest));
    const auto seed = json.at("seed").get<std::uint64_t>();
    Checkpoint checkpoint;
    for (const Json& entry : json.at("weights")) {
      checkpoint.state_dict[entry.at("name").get<std::string>()] = make_weights(entry, seed);
    }
    if (json.contains("hparams")) {
      for (const auto& [name, value] : json.at("hparams").items()) {
        checkpoint.hparams[name] = option_from(value);
      }
    }
    return checkpoint;
  } catch (const Json::exception& error) {
    throw InputError(manifest.string(), error.what());
  }
}

ViGasWeights make_oracle_vigas(const std::filesystem::path& manifest) {
  const std::string where = manifest.string();
  return vigas_weights(
      weight_file_from_checkpoint(make_oracle_checkpoint(manifest), KeepTensors::required, where),
      where);
}

}  // namespace earpoint
