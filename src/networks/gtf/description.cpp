#include <earpoint/gtf/description.h>

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/ears.h>
#include <earpoint/core/quote.h>
#include <earpoint/core/strict_json.h>
#include <earpoint/error.h>
#include <earpoint/gtf/constants.h>
#include <earpoint/network/checked_tensors.h>
#include <earpoint/network/description_head.h>
#include <earpoint/network/layer_shapes.h>

namespace earpoint {
namespace {

using Json = nlohmann::json;

constexpr int kFormat = 1;
constexpr std::string_view kNetwork = "gtf";
constexpr int kLargestWidth = 4096;
constexpr int kMostFrames = 64;

/// The same test as for widths, of a number that may have a fraction. NaN fails.
void check_seconds(std::string_view where, std::string_view field, double value, double least,
                   double most) {
  if (value >= least && value <= most) return;
  throw InputError(where,
                   fmt::format("{}: expected {} to {}, found {}", field, least, most, value));
}

void check_senses(const GtfDescription& d, std::string_view where) {
  constexpr int kShrink = 1 << GtfDescription::kPictureLayers;
  check_range(where, "picture_px", d.picture_px, 0, 1024);
  if (d.picture_px % kShrink != 0) {
    throw InputError(where, fmt::format("picture_px: expected a multiple of {}, found {}", kShrink,
                                        d.picture_px));
  }
  constexpr int kMostSightPoints = 16;
  check_range(where, "sight_points", d.sight_points, 0, d.picture_px > 0 ? kMostSightPoints : 0);
  if (d.delays && !d.geometry) {
    throw InputError(where, "delays: expected false, as there is no geometry, found true");
  }
  if (d.ear_delays && !d.delays) {
    throw InputError(where, "ear_delays: expected false, as delays is, found true");
  }
  if (d.expected_level && !d.geometry) {
    throw InputError(where, "expected_level: expected false, as there is no geometry, found true");
  }
}

std::vector<double> numbers_in(const Json& list, std::string_view where, std::string_view field) {
  std::vector<double> numbers;
  for (const Json& json : list) {
    if (!json.is_number()) {
      throw InputError(
          where, fmt::format("'{}': expected numbers, found {}", field, in_quotes(json.dump())));
    }
    numbers.push_back(json.get<double>());
  }
  return numbers;
}

void add_picture_encoder(TensorShapes& shapes, const GtfDescription& d) {
  for (int i = 0; i < GtfDescription::kPictureLayers; ++i) {
    const std::int64_t from = GtfDescription::kPictureChannels[i];
    const std::int64_t to = GtfDescription::kPictureChannels[i + 1];
    add_layer(shapes, fmt::format("picture.{}", i), {to, from, 3, 3});
    shapes[fmt::format("picture.{}.norm.weight", i)] = {to};
    shapes[fmt::format("picture.{}.norm.bias", i)] = {to};
  }
  const std::int64_t side = d.picture_px >> GtfDescription::kPictureLayers;
  add_layer(shapes, "picture.output",
            {d.picture_width,
             side * side * GtfDescription::kPictureChannels[GtfDescription::kPictureLayers]});
}

}  // namespace

std::optional<std::vector<int>> gtf_band_edges(int bands) {
  // The bend of the scale: this share of the bands has this many bins.
  constexpr double kBend = 0.4;
  constexpr double kBinsAtBend = 0.08 * GtfDescription::kBins + 4.0;
  std::vector<int> edges;
  for (int i = 0; i <= bands; ++i) {
    const double share = static_cast<double>(i) / bands;
    const double bins = share < kBend ? share / kBend * kBinsAtBend
                                      : kBinsAtBend + (share - kBend) / (1.0 - kBend) *
                                                          (GtfDescription::kBins - kBinsAtBend);
    const int edge = static_cast<int>(std::nearbyint(bins));
    if (!edges.empty() && edge <= edges.back()) return std::nullopt;
    edges.push_back(edge);
  }
  return edges;
}

void check_description(const GtfDescription& d, std::string_view where) {
  check_range(where, "window_samples", d.window_samples, GtfDescription::kFftSize, 1 << 20);
  if (d.highpass_cutoff_hz) {
    check_seconds(where, "highpass_cutoff_hz", *d.highpass_cutoff_hz, 1.0, 1000.0);
  }
  check_range(where, "channels", d.channels, 1, kLargestWidth);
  check_range(where, "layers", d.layers, 1, 64);
  check_range(where, "bands", d.bands, 1, GtfDescription::kBins);
  if (!gtf_band_edges(d.bands)) {
    throw InputError(where, fmt::format("bands: too many for {} bins, found {}",
                                        GtfDescription::kBins, d.bands));
  }
  check_range(where, "past_frames", d.past_frames, 0, kMostFrames);
  check_range(where, "future_frames", d.future_frames, 0, kMostFrames);
  check_range(where, "look_ahead_frames", d.look_ahead_frames, 0, kMostFrames);
  check_range(where, "tails_s: how many", static_cast<std::int64_t>(d.tails_s.size()), 0, 8);
  for (const double tail_s : d.tails_s) check_seconds(where, "tails_s", tail_s, 0.001, 10.0);
  check_senses(d, where);
  check_range(where, "picture_width", d.picture_width, 1, kLargestWidth);
  check_range(where, "locator_width", d.locator_width, 1, kLargestWidth);
  check_range(where, "summary_width", d.summary_width, 1, kLargestWidth);
  check_range(where, "conditioning_width", d.conditioning_width, 1, kLargestWidth);
  constexpr int kMostRounds = 16;
  check_range(where, "phase_rounds", d.phase_rounds, 0, kMostRounds);
}

std::string to_json(const GtfDescription& d) {
  Json highpass;
  if (d.highpass_cutoff_hz) highpass = *d.highpass_cutoff_hz;
  Json json{{"format", kFormat},
            {"network", kNetwork},
            {"sample_rate_hz", GtfDescription::kSampleRateHz},
            {"window_samples", d.window_samples},
            {"highpass_cutoff_hz", highpass},
            {"channels", d.channels},
            {"layers", d.layers},
            {"bands", d.bands},
            {"past_frames", d.past_frames},
            {"future_frames", d.future_frames},
            {"look_ahead_frames", d.look_ahead_frames},
            {"tails_s", d.tails_s},
            {"picture_px", d.picture_px},
            {"box", d.box},
            {"geometry", d.geometry},
            {"delays", d.delays},
            {"picture_width", d.picture_width},
            {"locator_width", d.locator_width},
            {"summary_width", d.summary_width},
            {"conditioning_width", d.conditioning_width}};
  // Left out where they are as in the first networks, so that their files keep the same bytes.
  if (d.ear_delays) json["ear_delays"] = true;
  if (d.expected_level) json["expected_level"] = true;
  if (d.phase_rounds > 0) json["phase_rounds"] = d.phase_rounds;
  if (d.sight_points > 0) json["sight_points"] = d.sight_points;
  if (d.texture) json["texture"] = true;
  if (d.dry_voice) json["dry_voice"] = true;
  return json.dump();
}

GtfDescription gtf_description_from_json(std::string_view text, std::string_view where) {
  constexpr int kDepth = 2;  // the object, its list of tails
  const Json json = parse_strict_json(text, where, kDepth);
  JsonObjectReader reader(json, where);
  expect_head(reader, where, kFormat, kNetwork);
  check_range(where, "sample_rate_hz", reader.integer("sample_rate_hz"),
              GtfDescription::kSampleRateHz, GtfDescription::kSampleRateHz);
  GtfDescription d;
  d.window_samples = reader.integer("window_samples");
  if (!reader.value("highpass_cutoff_hz").is_null()) {
    d.highpass_cutoff_hz = reader.number("highpass_cutoff_hz");
  }
  d.channels = reader.integer("channels");
  d.layers = reader.integer("layers");
  d.bands = reader.integer("bands");
  d.past_frames = reader.integer("past_frames");
  d.future_frames = reader.integer("future_frames");
  d.look_ahead_frames = reader.integer("look_ahead_frames");
  d.tails_s = numbers_in(reader.list("tails_s"), where, "tails_s");
  d.picture_px = reader.integer("picture_px");
  d.box = reader.boolean("box");
  d.geometry = reader.boolean("geometry");
  d.delays = reader.boolean("delays");
  d.picture_width = reader.integer("picture_width");
  d.locator_width = reader.integer("locator_width");
  d.summary_width = reader.integer("summary_width");
  d.conditioning_width = reader.integer("conditioning_width");
  if (reader.has("ear_delays")) d.ear_delays = reader.boolean("ear_delays");
  if (reader.has("expected_level")) d.expected_level = reader.boolean("expected_level");
  if (reader.has("phase_rounds")) d.phase_rounds = reader.integer("phase_rounds");
  if (reader.has("sight_points")) d.sight_points = reader.integer("sight_points");
  if (reader.has("texture")) d.texture = reader.boolean("texture");
  if (reader.has("dry_voice")) d.dry_voice = reader.boolean("dry_voice");
  reader.expect_nothing_else();
  check_description(d, where);
  return d;
}

TensorShapes required_tensors(const GtfDescription& d) {
  TensorShapes shapes;
  if (d.geometry) {
    shapes["head.power"] = {GtfDescription::kHeadAzimuths, kEars, GtfDescription::kHeadBands};
    shapes["head.diffuse_power"] = {kEars, GtfDescription::kHeadBands};
    shapes["head.delay_s"] = {GtfDescription::kHeadAzimuths, kEars};
    add_layer(shapes, "locator.0", {d.locator_width, d.locator_inputs()});
    add_layer(shapes, "locator.1", {d.locator_width, d.locator_width});
    add_layer(shapes, "locator.2", {gtf::kLocatorOutputs, d.locator_width});
  }
  if (d.picture_px > 0) add_picture_encoder(shapes, d);
  if (d.sight_points > 0) {
    add_layer(shapes, "sight",
              {GtfDescription::kSightWidth,
               GtfDescription::kPictureChannels[GtfDescription::kSightLayer]});
  }
  add_layer(shapes, "summary", {d.summary_width, d.summary_features()});
  add_layer(shapes, "conditioning.0", {d.conditioning_width, d.conditioning_inputs()});
  add_layer(shapes, "conditioning.1", {d.conditioning_width, d.conditioning_width});
  add_layer(shapes, "trunk.input", {d.channels, d.frame_features()});
  for (int i = 0; i < d.layers; ++i) {
    add_layer(shapes, fmt::format("trunk.{}", i), {d.channels, d.channels, gtf::kTrunkTaps});
    add_layer(shapes, fmt::format("trunk.{}.film", i),
              {std::int64_t{2} * d.channels, d.conditioning_width});
  }
  const std::int64_t kernels = std::int64_t{kEars} * kEars * d.taps() * d.bands;
  add_layer(shapes, "kernel", {kernels, d.channels});
  add_layer(shapes, "kernel.static", {kernels, d.conditioning_width});
  constexpr std::int64_t kGains = std::int64_t{kEars} * GtfDescription::kBins;
  add_layer(shapes, "gain", {kGains, d.channels});
  add_layer(shapes, "gain.static", {kGains, d.conditioning_width});
  if (d.dry_voice) {
    add_layer(shapes, "dry", {GtfDescription::kBins, d.channels});
    add_layer(shapes, "dry.static", {GtfDescription::kBins, d.conditioning_width});
  }
  if (d.delays) add_layer(shapes, "phase", {std::int64_t{kEars} * d.bands, d.conditioning_width});
  return shapes;
}

bool is_gtf_table(std::string_view name) { return name.starts_with("head."); }

}  // namespace earpoint
