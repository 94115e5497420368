#include <array>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/quote.h>
#include <earpoint/core/strict_json.h>
#include <earpoint/error.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/vigas/description.h>

namespace earpoint {
namespace {

using Json = nlohmann::json;

constexpr int kFormat = 1;
constexpr std::string_view kTrunk = "resnet18";

constexpr std::array<std::pair<PoseEncoding, std::string_view>, 3> kPoseEncodings{
    {{PoseEncoding::soundspaces, "soundspaces"},
     {PoseEncoding::replay, "replay"},
     {PoseEncoding::full, "full"}}};
constexpr std::array<std::pair<BoxEncoding, std::string_view>, 3> kBoxEncodings{
    {{BoxEncoding::soundspaces, "soundspaces"},
     {BoxEncoding::corners, "corners"},
     {BoxEncoding::centre, "centre"}}};

template <typename Names, typename Value>
std::string_view name_in(const Names& names, Value value) {
  for (const auto& [candidate, name] : names) {
    if (candidate == value) return name;
  }
  throw std::logic_error("an encoding without a name");
}

template <typename Names>
auto value_in(const Names& names, JsonObjectReader& reader, const std::string& key,
              std::string_view where) {
  const std::string found = reader.string(key);
  std::string known;
  for (const auto& [value, name] : names) {
    if (name == found) return value;
    known += fmt::format("{}'{}'", known.empty() ? "" : " or ", name);
  }
  throw InputError(where, fmt::format("'{}': expected {}, found {}", key, known, in_quotes(found)));
}

ImageEncoderDescription image_encoder_from(const Json& json, std::string_view where) {
  JsonObjectReader reader(json, where);
  const std::string architecture = reader.string("architecture");
  if (architecture != kTrunk) {
    throw InputError(where, fmt::format("'architecture': expected '{}', found {}", kTrunk,
                                        in_quotes(architecture)));
  }
  ImageEncoderDescription encoder{reader.integer("width_px"), reader.integer("height_px"),
                                  reader.integer("channels")};
  if (reader.has("trunk_channels")) encoder.trunk_channels = reader.integer("trunk_channels");
  reader.expect_nothing_else();
  return encoder;
}

std::vector<ConditioningInput> inputs_from(const Json& list, std::string_view where) {
  std::vector<ConditioningInput> inputs;
  for (const Json& json : list) {
    JsonObjectReader reader(json, where);
    inputs.push_back({reader.string("name"), reader.integer("width")});
    reader.expect_nothing_else();
  }
  return inputs;
}

}  // namespace

std::string to_json(const ViGasDescription& d) {
  Json inputs = Json::array();
  for (const ConditioningInput& input : d.inputs) {
    inputs.push_back({{"name", input.name}, {"width", input.width}});
  }
  Json image_encoder;
  if (d.image_encoder) {
    image_encoder = {{"architecture", kTrunk},
                     {"width_px", d.image_encoder->width_px},
                     {"height_px", d.image_encoder->height_px},
                     {"channels", d.image_encoder->channels},
                     {"trunk_channels", d.image_encoder->trunk_channels}};
  }
  Json highpass;
  if (d.highpass_cutoff_hz) highpass = *d.highpass_cutoff_hz;
  return Json{{"format", kFormat},
              {"network", "vigas"},
              {"pose_encoding", name_in(kPoseEncodings, d.pose_encoding)},
              {"box_encoding", name_in(kBoxEncodings, d.box_encoding)},
              {"sample_rate_hz", d.sample_rate_hz},
              {"window_samples", d.window_samples},
              {"highpass_cutoff_hz", highpass},
              {"hop_samples", d.hop_samples},
              {"image_encoder", image_encoder},
              {"inputs", inputs},
              {"fusion_width", d.fusion_width},
              {"conditioning_width", d.conditioning_width},
              {"audio_channels", d.audio_channels},
              {"channels", d.channels},
              {"blocks", d.blocks},
              {"layers_per_block", d.layers_per_block},
              {"kernel_size", d.kernel_size},
              {"dilation_base", d.dilation_base},
              {"acausal", d.acausal}}
      .dump();
}

ViGasDescription vigas_description_from_json(std::string_view text, std::string_view where) {
  constexpr int kDepth = 3;  // the object, its list of inputs, an input
  const Json json = parse_strict_json(text, where, kDepth);
  JsonObjectReader reader(json, where);
  if (const int format = reader.integer("format"); format != kFormat) {
    throw InputError(where, fmt::format("'format': expected {}, found {}", kFormat, format),
                     "was it written by a newer version?");
  }
  if (const std::string network = reader.string("network"); network != "vigas") {
    throw InputError(where,
                     fmt::format("'network': expected 'vigas', found {}", in_quotes(network)));
  }
  ViGasDescription d;
  d.pose_encoding = value_in(kPoseEncodings, reader, "pose_encoding", where);
  d.box_encoding = value_in(kBoxEncodings, reader, "box_encoding", where);
  d.sample_rate_hz = reader.integer("sample_rate_hz");
  d.window_samples = reader.integer("window_samples");
  if (!reader.value("highpass_cutoff_hz").is_null()) {
    d.highpass_cutoff_hz = reader.number("highpass_cutoff_hz");
  }
  d.hop_samples = reader.integer("hop_samples");
  if (const Json& encoder = reader.value("image_encoder"); !encoder.is_null()) {
    d.image_encoder = image_encoder_from(encoder, fmt::format("{}: 'image_encoder'", where));
  }
  d.inputs = inputs_from(reader.list("inputs"), fmt::format("{}: 'inputs'", where));
  d.fusion_width = reader.integer("fusion_width");
  d.conditioning_width = reader.integer("conditioning_width");
  d.audio_channels = reader.integer("audio_channels");
  d.channels = reader.integer("channels");
  d.blocks = reader.integer("blocks");
  d.layers_per_block = reader.integer("layers_per_block");
  d.kernel_size = reader.integer("kernel_size");
  d.dilation_base = reader.integer("dilation_base");
  d.acausal = reader.boolean("acausal");
  reader.expect_nothing_else();
  check_description(d, where);
  return d;
}

}  // namespace earpoint
