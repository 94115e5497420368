#include <earpoint/train/train_config.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/core/quote.h>
#include <earpoint/core/strict_json.h>
#include <earpoint/dataset/ambient.h>
#include <earpoint/error.h>
#include <earpoint/network/pose_encoding.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::string_view kFormat = "earpoint-train-1";
constexpr int kDepth = 4;
constexpr int kLongestChain = 8;

/// Reads optional keys and checks their ranges.
class Section {
 public:
  Section(const Json& json, std::string where) : reader_(json, where), where_(std::move(where)) {}

  void take(const char* key, int& value, int least, int most) {
    if (reader_.has(key)) value = reader_.integer(key);
    check(key, value, least, most);
  }
  void take(const char* key, std::int64_t& value, int least) {
    if (reader_.has(key)) value = reader_.integer(key);
    check(key, static_cast<double>(value), least, std::numeric_limits<int>::max());
  }
  void take(const char* key, double& value, double least, double most) {
    if (reader_.has(key)) value = reader_.number(key);
    check(key, value, least, most);
  }
  void take(const char* key, std::optional<double>& value, double least, double most) {
    if (is_null(key)) value.reset();
    if (is_null(key) || !reader_.has(key)) return;
    value = reader_.number(key);
    check(key, *value, least, most);
  }
  void take(const char* key, bool& value) {
    if (reader_.has(key)) value = reader_.boolean(key);
  }
  void take(const char* key, std::string& value) {
    if (reader_.has(key)) value = reader_.string(key);
  }
  template <typename Value, std::size_t kCount>
  void take(const char* key, Value& value,
            const std::array<std::pair<Value, std::string_view>, kCount>& names) {
    if (!reader_.has(key)) return;
    const std::string found = reader_.string(key);
    std::string known;
    for (const auto& [candidate, name] : names) {
      if (name == found) {
        value = candidate;
        return;
      }
      known += fmt::format("{}\"{}\"", known.empty() ? "" : ", ", name);
    }
    fail(key, "one of " + known, '"' + found + '"');
  }
  /// Whether the key is there and null.
  bool is_null(const char* key) { return reader_.has(key) && reader_.value(key).is_null(); }
  [[noreturn]] void fail(const char* key, const std::string& expected, const std::string& found) {
    throw InputError(where_, fmt::format("'{}': expected {}, found {}", key, expected, found));
  }
  JsonObjectReader& reader() { return reader_; }
  void end() const { reader_.expect_nothing_else(); }

 private:
  void check(const char* key, double value, double least, double most) {
    if (value >= least && value <= most) return;  // written so that NaN fails
    fail(key, fmt::format("{:g} to {:g}", least, most), fmt::format("{:g}", value));
  }

  JsonObjectReader reader_;
  std::string where_;
};

constexpr int kMost = std::numeric_limits<int>::max();

TrainingPlan plan_from(const Json& json, const std::string& where) {
  constexpr std::array<std::pair<Schedule, std::string_view>, 2> kSchedules{
      {{Schedule::constant, "constant"}, {Schedule::cosine, "cosine"}}};
  constexpr std::array<std::pair<Keep, std::string_view>, 2> kKept{
      {{Keep::best, "best"}, {Keep::last, "last"}}};
  Section section(json, where);
  TrainingPlan plan;
  int seed = 1;
  section.take("seed", seed, 0, kMost);
  plan.seed = static_cast<std::uint64_t>(seed);
  section.take("batch", plan.batch, 1, 65536);
  plan.steps = section.reader().integer("steps");
  section.take("steps", plan.steps, 1);
  section.take("minutes", plan.minutes, 1e-3, 1e6);
  section.take("learning_rate", plan.learning_rate, 0.0, 10.0);
  section.take("schedule", plan.schedule, kSchedules);
  section.take("warmup_steps", plan.warmup_steps, 0);
  section.take("validate_every", plan.validate_every, 1);
  section.take("keep", plan.keep, kKept);
  section.take("patience", plan.patience, 0, kMost);
  section.end();
  return plan;
}

Json parsed(std::string_view json, std::string_view where) {
  return parse_strict_json(json, where, kDepth);
}

/// The configuration merged into the one that it extends, key by key.
Json merged(const fs::path& path, int chain) {
  Json json = parsed(read_text_file(path), path.string());
  if (!json.is_object() || !json.contains("extends")) return json;
  if (chain == kLongestChain) throw InputError(path.string(), "'extends': the chain is too long");
  const Json name = json["extends"];
  if (!name.is_string()) throw InputError(path.string(), "'extends': expected a file's name");
  Json base = merged(path.parent_path() / name.get<std::string>(), chain + 1);
  json.erase("extends");
  // Keys of objects are overridden one by one; null is a value here, unlike in RFC 7386.
  const std::function<void(Json&, const Json&)> override_with = [&](Json& below,
                                                                    const Json& above) {
    for (const auto& [key, value] : above.items()) {
      if (value.is_object() && below.contains(key) && below[key].is_object()) {
        override_with(below[key], value);
      } else {
        below[key] = value;
      }
    }
  };
  override_with(base, json);
  return base;
}

void set_value(Json& json, const ConfigSetting& setting, const std::string& where) {
  const auto refuse = [&](const std::string& problem) {
    throw InputError(where, fmt::format("cannot set {}: {}", in_quotes(setting.key), problem));
  };
  Json* at = &json;
  std::string_view left = setting.key;
  for (;;) {
    const std::size_t dot = left.find('.');
    const std::string name(left.substr(0, dot));
    if (name.empty()) refuse("expected names separated by dots, like training.steps");
    if (!at->is_object()) refuse(fmt::format("{} is not in an object", in_quotes(name)));
    at = &(*at)[name];
    if (dot == std::string_view::npos) break;
    if (at->is_null()) *at = Json::object();
    left.remove_prefix(dot + 1);
  }
  *at =
      Json::accept(setting.value)
          ? parsed(setting.value, fmt::format("{}: the value of {}", where, in_quotes(setting.key)))
          : Json(setting.value);
}

void add_inputs(ViGasDescription& d, bool sees_box) {
  if (d.image_encoder) d.inputs.push_back({"visual_feat", d.image_encoder->feature_width()});
  d.inputs.push_back({"tgt_pose", 3});
  d.inputs.push_back({"tgt_rotation", d.pose_encoding == PoseEncoding::soundspaces ? 2 : 6});
  if (sees_box) d.inputs.push_back({"bboxes", 4});
}

/// The published network's encoder for the data set with this pose encoding.
ImageEncoderDescription published_encoder(PoseEncoding encoding) {
  if (encoding == PoseEncoding::replay) return {384, 216, 8};
  return {256, 256, 8};
}

/// @param encoder  defaults for missing keys
ImageEncoderDescription encoder_from(const Json& json, const std::string& where,
                                     ImageEncoderDescription encoder) {
  Section section(json, where);
  section.take("width_px", encoder.width_px, 32, 1024);
  section.take("height_px", encoder.height_px, 32, 1024);
  section.take("channels", encoder.channels, 1, 512);
  section.take("trunk_channels", encoder.trunk_channels, 1, 512);
  section.end();
  return encoder;
}

}  // namespace

double learning_rate_at(const TrainingPlan& plan, std::int64_t step, double progress) {
  double rate = plan.learning_rate;
  if (plan.schedule == Schedule::cosine) rate *= 0.5 * (1.0 + std::cos(kPi * progress));
  if (step < plan.warmup_steps) {
    rate *= static_cast<double>(step + 1) / static_cast<double>(plan.warmup_steps);
  }
  return rate;
}

TrainConfig train_config_from_json(std::string_view text, std::string_view where) {
  const Json json = parsed(text, where);
  JsonObjectReader reader(json, where);
  if (const std::string format = reader.string("format"); format != kFormat) {
    throw InputError(where,
                     fmt::format("'format': expected \"{}\", found \"{}\"", kFormat, format));
  }
  TrainConfig config;
  Json network = reader.value("network");
  if (!network.is_object() || !network.contains("kind") || !network["kind"].is_string()) {
    throw InputError(where, "'network': expected an object with a 'kind'");
  }
  config.kind = network["kind"].get<std::string>();
  network.erase("kind");
  config.network = network.dump();
  config.data = reader.has("data") ? reader.value("data").dump() : "{}";
  config.training = plan_from(reader.value("training"), fmt::format("{}: 'training'", where));
  reader.expect_nothing_else();
  config.text = json.dump(1) + "\n";
  return config;
}

TrainConfig read_train_config(const fs::path& path, std::span<const ConfigSetting> settings,
                              std::string where) {
  if (where.empty()) where = path.string();
  Json json = merged(path, 0);
  for (const ConfigSetting& setting : settings) set_value(json, setting, where);
  return train_config_from_json(json.dump(), where);
}

ViGasConfig vigas_config_from_json(std::string_view text, std::string_view where, bool separated) {
  constexpr std::array<std::pair<LossKind, std::string_view>, 2> kLosses{
      {{LossKind::magnitude, "magnitude"}, {LossKind::log_magnitude, "log_magnitude"}}};
  constexpr std::array<std::pair<BoxEncoding, std::string_view>, 3> kBoxEncodings{
      {{BoxEncoding::corners, "corners"},
       {BoxEncoding::centre, "centre"},
       {BoxEncoding::soundspaces, "soundspaces"}}};
  constexpr std::array<std::pair<PoseEncoding, std::string_view>, 3> kPoseEncodings{
      {{PoseEncoding::full, "full"},
       {PoseEncoding::soundspaces, "soundspaces"},
       {PoseEncoding::replay, "replay"}}};
  const Json json = parsed(text, where);
  Section section(json, std::string(where));
  ViGasConfig config;
  ViGasDescription& d = config.description;
  d.pose_encoding = PoseEncoding::full;
  section.take("pose_encoding", d.pose_encoding, kPoseEncodings);
  d.box_encoding = d.pose_encoding == PoseEncoding::soundspaces ? BoxEncoding::soundspaces
                                                                : BoxEncoding::corners;
  if (separated) d.highpass_cutoff_hz = kSeparationCutoffHz;
  d.image_encoder = published_encoder(d.pose_encoding);
  if (section.is_null("picture")) {
    d.image_encoder.reset();
  } else if (section.reader().has("picture")) {
    d.image_encoder = encoder_from(section.reader().value("picture"),
                                   fmt::format("{}: 'picture'", where), *d.image_encoder);
  }
  bool sees_box = true;
  section.take("box", sees_box);
  add_inputs(d, sees_box);
  section.take("fusion_width", d.fusion_width, 1, 1 << 16);
  section.take("conditioning_width", d.conditioning_width, 1, 1 << 16);
  section.take("channels", d.channels, 1, 4096);
  section.take("blocks", d.blocks, 1, 1024);
  section.take("layers_per_block", d.layers_per_block, 1, 64);
  section.take("kernel_size", d.kernel_size, 1, 1024);
  section.take("dilation_base", d.dilation_base, 1, 64);
  section.take("acausal", d.acausal);
  section.take("loss", config.loss, kLosses);
  section.take("place", config.place, 0.0, 1e3);
  section.take("place_steps", config.place_steps, 0);
  if (config.place_steps > 0 && config.place == 0.0) {
    section.fail("place", "more than 0 where there are 'place_steps'", "0");
  }
  section.take("box_encoding", d.box_encoding, kBoxEncodings);
  std::string start = "identity";
  section.take("init", start);
  if (start == "released" || start == "identity") {
    config.start = start == "released" ? ViGasStart::released : ViGasStart::identity;
  } else if (start.ends_with(".safetensors")) {
    config.start = ViGasStart::file;
    config.start_file = start;
  } else {
    section.fail("init", "\"identity\", \"released\" or a weight file", '"' + start + '"');
  }
  if (section.reader().has("image_trunk") && !section.is_null("image_trunk")) {
    if (!d.image_encoder) section.fail("image_trunk", "nothing without a picture", "one");
    config.trunk = section.reader().string("image_trunk");
  }
  section.end();
  check_description(d, where);
  return config;
}

PairOptions pair_options_from_json(std::string_view text, std::string_view where) {
  constexpr std::array<std::pair<Alignment, std::string_view>, 3> kAlignments{
      {{Alignment::responses, "responses"},
       {Alignment::gcc_phat, "gcc_phat"},
       {Alignment::none, "none"}}};
  constexpr std::array<std::pair<PairTarget, std::string_view>, 2> kTargets{
      {{PairTarget::viewpoint, "viewpoint"}, {PairTarget::near_microphone, "near_microphone"}}};
  constexpr std::array<std::pair<SpeakerBoxes, std::string_view>, 3> kBoxes{
      {{SpeakerBoxes::truth, "true"},
       {SpeakerBoxes::detected, "detected"},
       {SpeakerBoxes::none, "none"}}};
  constexpr std::array<std::pair<AmbientSeparation, std::string_view>, 3> kSeparations{
      {{AmbientSeparation::bandpass, "bandpass"},
       {AmbientSeparation::subtract, "subtract"},
       {AmbientSeparation::mmse, "mmse"}}};
  const Json json = parsed(text, where);
  Section section(json, std::string(where));
  PairOptions options;
  int samples = static_cast<int>(options.samples);
  section.take("window_samples", samples, 1000, 1 << 20);
  options.samples = samples;
  section.take("any_speech", options.any_speech);
  section.take("mirror", options.mirror);
  section.take("spoilt_pictures", options.spoilt_pictures, 0.0, 1.0);
  section.take("wide_pictures", options.wide_pictures, 0.0, 1.0);
  section.take("hidden_boxes", options.hidden_boxes, 0.0, 1.0);
  section.take("boxes", options.boxes, kBoxes);
  section.take("farthest_move_m", options.farthest_move_m, 0.1, 100.0);
  section.take("most_gain_db", options.most_gain_db, 0.0, 100.0);
  section.take("align", options.alignment, kAlignments);
  section.take("target", options.target, kTargets);
  if (options.target == PairTarget::near_microphone && options.alignment != Alignment::responses) {
    section.fail("align", "\"responses\" where 'target' is \"near_microphone\"", "another");
  }
  section.take("ambient_db", options.ambient_db, -120.0, 0.0);
  section.take("faint_speech", options.faint_speech, 0.0, 1.0);
  section.take("second_voices", options.second_voices, 0.0, 1.0);
  if (options.second_voices > 0.0 && options.target != PairTarget::viewpoint) {
    section.fail("second_voices", "0 where 'target' is \"near_microphone\"", "more");
  }
  section.take("separate", options.separate);
  section.take("ambient", options.separation, kSeparations);
  if (options.separation != AmbientSeparation::bandpass &&
      !(options.separate && options.ambient_db)) {
    section.fail("ambient", "\"bandpass\" where no room noise is separated", "another");
  }
  if (!options.separate && !options.ambient_db) {
    section.fail("separate", "true where 'ambient_db' is null", "false");
  }
  int pairs = static_cast<int>(options.validation_pairs);
  section.take("validation_pairs", pairs, 0, kMost);
  options.validation_pairs = static_cast<std::size_t>(pairs);
  section.end();
  return options;
}

}  // namespace earpoint
