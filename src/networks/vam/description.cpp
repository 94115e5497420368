#include <earpoint/vam/description.h>

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
constexpr std::string_view kNetwork = "vam";
constexpr int kOutputTaps = 7;

std::vector<int> integers(const Json& list, std::string_view where, std::string_view key) {
  std::vector<int> values;
  for (const Json& item : list) {
    if (!item.is_number_integer() || item.get<std::int64_t>() < 1 ||
        item.get<std::int64_t>() > 4096) {
      throw InputError(where, fmt::format("'{}': expected numbers from 1 to 4096, found {}", key,
                                          in_quotes(item.dump())));
    }
    values.push_back(item.get<int>());
  }
  return values;
}

void add_norm(TensorShapes& shapes, const std::string& name, std::int64_t width) {
  shapes[name + ".weight"] = {width};
  shapes[name + ".bias"] = {width};
}

void add_block(TensorShapes& shapes, const std::string& name, const VamDescription& d) {
  const std::int64_t width = d.width();
  for (const char* attention : {".self", ".cross"}) {
    add_norm(shapes, name + attention + ".norm", width);
    for (const char* part : {".query", ".key", ".value", ".output"}) {
      add_layer(shapes, name + attention + part, {width, width});
    }
  }
  add_norm(shapes, name + ".convolution.norm", width);
  add_layer(shapes, name + ".convolution.expand", {2 * width, width});
  add_layer(shapes, name + ".convolution.depthwise", {width, 1, d.kernel_size});
  add_layer(shapes, name + ".convolution.project", {width, width});
  add_norm(shapes, name + ".feed_forward.norm", width);
  add_layer(shapes, name + ".feed_forward.expand", {d.feed_forward_width, width});
  add_layer(shapes, name + ".feed_forward.project", {width, d.feed_forward_width});
}

}  // namespace

int VamDescription::token_samples() const {
  int samples = 1;
  for (const int stride : strides) samples *= stride;
  return samples;
}

int VamDescription::image_tokens() const {
  return ((image_height_px + 31) / 32) * ((image_width_px + 31) / 32);
}

int VamDescription::encoder_inputs(int level) const {
  return level == 0 ? audio_channels : channels[level - 1];
}

int VamDescription::decoder_outputs(int level) const {
  return level == 0 ? (channels[0] + 1) / 2 : channels[level - 1];
}

void check_description(const VamDescription& d, std::string_view where) {
  check_range(where, "sample_rate_hz", d.sample_rate_hz, 1000, 384'000);
  check_range(where, "window_samples", d.window_samples, 1, 1 << 26);
  check_range(where, "hop_samples", d.hop_samples, 1, 1 << 20);
  if (d.highpass_cutoff_hz &&
      !(*d.highpass_cutoff_hz > 0 && *d.highpass_cutoff_hz < 0.5 * d.sample_rate_hz)) {
    throw InputError(where, fmt::format("highpass_cutoff_hz: expected more than 0 and less than "
                                        "half of the sample rate, found {}",
                                        *d.highpass_cutoff_hz));
  }
  check_range(where, "audio_channels", d.audio_channels, 1, 64);
  check_range(where, "image_width_px", d.image_width_px, 1, 1 << 13);
  check_range(where, "image_height_px", d.image_height_px, 1, 1 << 13);
  check_range(where, "trunk_channels", d.trunk_channels, 1, 512);
  check_range(where, "number of strides", d.levels(), 1, 8);
  check_range(where, "number of channels", std::ssize(d.channels), d.levels(), d.levels());
  for (int level = 0; level < d.levels(); ++level) {
    check_range(where, "strides", d.strides[level], 1, 16);
    check_range(where, "channels", d.channels[level], 1, 4096);
  }
  check_range(where, "samples in a token", d.token_samples(), 1, 1 << 16);
  check_range(where, "blocks", d.blocks, 0, 64);
  check_range(where, "heads", d.heads, 1, d.width());
  check_range(where, "width of a token left over by the heads", d.width() % d.heads, 0, 0);
  check_range(where, "feed_forward_width", d.feed_forward_width, 1, 1 << 14);
  check_range(where, "kernel_size", d.kernel_size, 1, 255);
  check_range(where, "kernel_size modulo 2", d.kernel_size % 2, 1, 1);
}

std::string to_json(const VamDescription& d) {
  Json highpass;
  if (d.highpass_cutoff_hz) highpass = *d.highpass_cutoff_hz;
  return Json{{"format", kFormat},
              {"network", kNetwork},
              {"sample_rate_hz", d.sample_rate_hz},
              {"window_samples", d.window_samples},
              {"highpass_cutoff_hz", highpass},
              {"hop_samples", d.hop_samples},
              {"audio_channels", d.audio_channels},
              {"image_width_px", d.image_width_px},
              {"image_height_px", d.image_height_px},
              {"trunk_channels", d.trunk_channels},
              {"strides", d.strides},
              {"channels", d.channels},
              {"blocks", d.blocks},
              {"heads", d.heads},
              {"feed_forward_width", d.feed_forward_width},
              {"kernel_size", d.kernel_size}}
      .dump();
}

VamDescription vam_description_from_json(std::string_view text, std::string_view where) {
  constexpr int kDepth = 2;  // the object, a list
  const Json json = parse_strict_json(text, where, kDepth);
  JsonObjectReader reader(json, where);
  expect_head(reader, where, kFormat, kNetwork);
  VamDescription d;
  d.sample_rate_hz = reader.integer("sample_rate_hz");
  d.window_samples = reader.integer("window_samples");
  if (!reader.value("highpass_cutoff_hz").is_null()) {
    d.highpass_cutoff_hz = reader.number("highpass_cutoff_hz");
  }
  d.hop_samples = reader.integer("hop_samples");
  d.audio_channels = reader.integer("audio_channels");
  d.image_width_px = reader.integer("image_width_px");
  d.image_height_px = reader.integer("image_height_px");
  d.trunk_channels = reader.integer("trunk_channels");
  d.strides = integers(reader.list("strides"), where, "strides");
  d.channels = integers(reader.list("channels"), where, "channels");
  d.blocks = reader.integer("blocks");
  d.heads = reader.integer("heads");
  d.feed_forward_width = reader.integer("feed_forward_width");
  d.kernel_size = reader.integer("kernel_size");
  reader.expect_nothing_else();
  check_description(d, where);
  return d;
}

TensorShapes required_tensors(const VamDescription& d) {
  TensorShapes shapes;
  add_resnet18(shapes, "visual_encoder", 3, d.trunk_channels);
  const std::int64_t width = d.width();
  add_layer(shapes, "image_projection", {width, d.map_channels() + VamDescription::kPoseWidth});
  shapes["image_position"] = {d.image_tokens(), width};
  add_layer(shapes, "sound_projection", {width, width + VamDescription::kPoseWidth});
  for (int level = 0; level < d.levels(); ++level) {
    add_layer(shapes, fmt::format("encoder.{}", level),
              {d.channels[level], d.encoder_inputs(level), d.taps(level)});
    const std::string decoder = fmt::format("decoder.{}", level);
    shapes[decoder + ".weight"] = {std::int64_t{2} * d.channels[level], d.decoder_outputs(level),
                                   d.taps(level)};
    shapes[decoder + ".bias"] = {d.decoder_outputs(level)};
  }
  for (int block = 0; block < d.blocks; ++block) {
    add_block(shapes, fmt::format("blocks.{}", block), d);
  }
  add_norm(shapes, "norm", width);
  add_layer(shapes, "output",
            {d.audio_channels, d.decoder_outputs(0) + d.audio_channels, kOutputTaps});
  return shapes;
}

}  // namespace earpoint
