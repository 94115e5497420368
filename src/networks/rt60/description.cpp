#include <earpoint/rt60/description.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/quote.h>
#include <earpoint/core/strict_json.h>
#include <earpoint/error.h>
#include <earpoint/network/checked_tensors.h>
#include <earpoint/network/description_head.h>
#include <earpoint/network/layer_shapes.h>

namespace earpoint {
namespace {

using Json = nlohmann::json;

constexpr int kFormat = 1;
constexpr std::string_view kNetwork = "rt60_estimator";

}  // namespace

void check_description(const Rt60Description& d, std::string_view where) {
  check_range(where, "channels", d.channels, 1, 1024);
  if (d.input_rms && !(*d.input_rms > 0 && *d.input_rms < 1e6)) {  // NaN fails, too
    throw InputError(
        where,
        fmt::format("input_rms: expected more than 0 and less than 1e6, found {}", *d.input_rms));
  }
}

std::string to_json(const Rt60Description& d) {
  Json input_rms;
  if (d.input_rms) input_rms = *d.input_rms;
  return Json{{"format", kFormat},
              {"network", kNetwork},
              {"sample_rate_hz", Rt60Description::kSampleRateHz},
              {"channels", d.channels},
              {"input_rms", input_rms}}
      .dump();
}

Rt60Description rt60_description_from_json(std::string_view text, std::string_view where) {
  const Json json = parse_strict_json(text, where, 1);
  JsonObjectReader reader(json, where);
  expect_head(reader, where, kFormat, kNetwork);
  check_range(where, "sample_rate_hz", reader.integer("sample_rate_hz"),
              Rt60Description::kSampleRateHz, Rt60Description::kSampleRateHz);
  Rt60Description d;
  if (json.contains("channels") || json.contains("input_rms")) {
    d.channels = reader.integer("channels");
    if (!reader.value("input_rms").is_null()) d.input_rms = reader.number("input_rms");
  }
  reader.expect_nothing_else();
  check_description(d, where);
  return d;
}

TensorShapes required_tensors(const Rt60Description& d) {
  TensorShapes shapes;
  add_resnet18(shapes, "feature_extraction", 1, d.channels);
  add_layer(shapes, "predictor.0", {1, std::int64_t{8} * d.channels});
  return shapes;
}

}  // namespace earpoint
