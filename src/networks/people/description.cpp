#include <earpoint/people/description.h>

#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/strict_json.h>
#include <earpoint/error.h>
#include <earpoint/network/checked_tensors.h>
#include <earpoint/network/description_head.h>
#include <earpoint/network/layer_shapes.h>

namespace earpoint {
namespace {

using Json = nlohmann::json;

constexpr int kFormat = 1;
constexpr std::string_view kNetwork = "people";

}  // namespace

void check_description(const PeopleDescription& d, std::string_view where) {
  check_range(where, "longest_px", d.longest_px, PeopleDescription::kCoarsest, 2048);
  if (d.longest_px % PeopleDescription::kCoarsest != 0) {
    throw InputError(where, fmt::format("longest_px: expected a multiple of {}, found {}",
                                        PeopleDescription::kCoarsest, d.longest_px));
  }
  check_range(where, "channels", d.channels, 1, 256);
}

std::string to_json(const PeopleDescription& d) {
  return Json{{"format", kFormat},
              {"network", kNetwork},
              {"longest_px", d.longest_px},
              {"channels", d.channels}}
      .dump();
}

PeopleDescription people_description_from_json(std::string_view text, std::string_view where) {
  const Json json = parse_strict_json(text, where, 1);
  JsonObjectReader reader(json, where);
  expect_head(reader, where, kFormat, kNetwork);
  PeopleDescription d;
  d.longest_px = reader.integer("longest_px");
  d.channels = reader.integer("channels");
  reader.expect_nothing_else();
  check_description(d, where);
  return d;
}

TensorShapes required_tensors(const PeopleDescription& d) {
  using D = PeopleDescription;
  TensorShapes shapes;
  shapes["stem.0.weight"] = {d.channels, 3, 3, 3};
  add_batch_norm(shapes, "stem.1", d.channels);
  std::int64_t from = d.channels;
  for (int stage = 0; stage < D::kStages; ++stage) {
    for (int block = 0; block < D::kBlocks.at(stage); ++block) {
      add_residual_block(shapes, fmt::format("stage.{}.{}", stage, block), from,
                         d.stage_channels(stage));
      from = d.stage_channels(stage);
    }
    if (stage > 0) {
      add_layer(shapes, fmt::format("lateral.{}", stage), {d.neck_channels(), from, 1, 1});
    }
  }
  const std::int64_t neck = d.neck_channels();
  for (int layer = 0; layer < D::kHeadLayers; ++layer) {
    shapes[fmt::format("head.{}.0.weight", layer)] = {neck, neck, 3, 3};
    add_batch_norm(shapes, fmt::format("head.{}.1", layer), neck);
  }
  add_layer(shapes, "output", {D::kOutputs, neck, 1, 1});
  return shapes;
}

}  // namespace earpoint
