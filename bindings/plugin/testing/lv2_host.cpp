#include "hosted_plugin.h"

#include <cmath>
#include <deque>
#include <map>
#include <stdexcept>

#include <lilv/lilv.h>
#include <lv2/atom/atom.h>
#include <lv2/buf-size/buf-size.h>
#include <lv2/core/lv2.h>
#include <lv2/options/options.h>
#include <lv2/urid/urid.h>

namespace earpoint::plugin {
namespace {

std::string symbol_of(ParameterId id) {
  if (id == kModel) return "model";
  if (id == kBypass) return "lv2_enabled";
  if (id == kStatus) return "status";
  for (const ParameterDescription& plain : plain_parameters()) {
    if (plain.id == id) return plain.symbol;
  }
  throw std::logic_error("no such parameter");
}

/// Numbers for names, as every full host has.
struct UridMap {
  static LV2_URID number_of(LV2_URID_Map_Handle self, const char* uri) {
    auto& numbers = static_cast<UridMap*>(self)->numbers;
    return numbers.emplace(uri, static_cast<LV2_URID>(numbers.size() + 100)).first->second;
  }
  std::map<std::string, LV2_URID> numbers;
  LV2_URID_Map map{this, number_of};
};

class Lv2Plugin : public HostedPlugin {
 public:
  Lv2Plugin(const std::filesystem::path& bundle, int sample_rate_hz, Lv2Host host)
      : world_(lilv_world_new()) {
    LilvNode* const folder = lilv_new_file_uri(world_, nullptr, (bundle.string() + "/").c_str());
    lilv_world_load_bundle(world_, folder);
    lilv_node_free(folder);
    LilvNode* const uri = lilv_new_uri(world_, "urn:earpoint:plugin");
    plugin_ = lilv_plugins_get_by_uri(lilv_world_get_all_plugins(world_), uri);
    lilv_node_free(uri);
    if (plugin_ == nullptr) throw std::runtime_error("the bundle has no such plugin");
    instantiate(sample_rate_hz, host);
    connect();
    lilv_instance_activate(instance_);
  }
  ~Lv2Plugin() override {
    lilv_instance_deactivate(instance_);
    lilv_instance_free(instance_);
    lilv_world_free(world_);
  }
  Lv2Plugin(const Lv2Plugin&) = delete;
  Lv2Plugin& operator=(const Lv2Plugin&) = delete;

  void set(ParameterId id, double value) override {
    if (id == kBypass) value = 1.0 - value;
    *port(symbol_of(id)) = static_cast<float>(value);
  }
  [[nodiscard]] double get(ParameterId id) const override {
    const double value = *port(symbol_of(id));
    return id == kBypass ? 1.0 - value : value;
  }

  [[nodiscard]] std::vector<std::string> model_names() const override {
    LilvNode* const symbol = lilv_new_string(world_, "model");
    LilvScalePoints* const points =
        lilv_port_get_scale_points(plugin_, lilv_plugin_get_port_by_symbol(plugin_, symbol));
    std::map<int, std::string> names;
    LILV_FOREACH(scale_points, i, points) {
      const LilvScalePoint* const point = lilv_scale_points_get(points, i);
      names[lilv_node_as_int(lilv_scale_point_get_value(point))] =
          lilv_node_as_string(lilv_scale_point_get_label(point));
    }
    lilv_scale_points_free(points);
    lilv_node_free(symbol);
    std::vector<std::string> in_order;
    in_order.reserve(names.size());
    for (const auto& [number, name] : names) in_order.push_back(name);
    return in_order;
  }

  void process(const float* const* in, float* const* out, std::ptrdiff_t frames) override {
    for (std::uint32_t c = 0; c < 2; ++c) {
      lilv_instance_connect_port(instance_, audio_in_[c], const_cast<float*>(in[c]));
      lilv_instance_connect_port(instance_, audio_out_[c], out[c]);
    }
    lilv_instance_run(instance_, static_cast<std::uint32_t>(frames));
  }
  [[nodiscard]] std::ptrdiff_t latency_samples() const override {
    return std::lround(controls_[lilv_plugin_get_latency_port_index(plugin_)]);
  }
  void restart() override {
    lilv_instance_deactivate(instance_);
    lilv_instance_activate(instance_);
  }

 private:
  void instantiate(int sample_rate_hz, Lv2Host host) {
    LV2_URID_Map& map = urids_.map;
    std::int32_t block = 512;
    const LV2_Options_Option options[] = {
        {LV2_OPTIONS_INSTANCE, 0, UridMap::number_of(&urids_, LV2_BUF_SIZE__maxBlockLength),
         sizeof(block), UridMap::number_of(&urids_, LV2_ATOM__Int), &block},
        {LV2_OPTIONS_INSTANCE, 0, 0, 0, 0, nullptr}};
    const LV2_Feature map_feature{LV2_URID__map, &map};
    const LV2_Feature options_feature{LV2_OPTIONS__options,
                                      const_cast<LV2_Options_Option*>(options)};
    const LV2_Feature* const features[] = {&map_feature, &options_feature, nullptr};
    instance_ = lilv_plugin_instantiate(plugin_, sample_rate_hz,
                                        host == Lv2Host::full ? features : nullptr);
    if (instance_ == nullptr) throw std::runtime_error("the LV2 plugin does not start");
  }

  void connect() {
    const std::uint32_t count = lilv_plugin_get_num_ports(plugin_);
    controls_.resize(count);
    lilv_plugin_get_port_ranges_float(plugin_, nullptr, nullptr, controls_.data());
    LilvNode* const audio = lilv_new_uri(world_, LV2_CORE__AudioPort);
    LilvNode* const input = lilv_new_uri(world_, LV2_CORE__InputPort);
    for (std::uint32_t i = 0; i < count; ++i) {
      const LilvPort* const port = lilv_plugin_get_port_by_index(plugin_, i);
      if (lilv_port_is_a(plugin_, port, audio)) {
        (lilv_port_is_a(plugin_, port, input) ? audio_in_ : audio_out_).push_back(i);
      } else {
        lilv_instance_connect_port(instance_, i, &controls_[i]);
      }
    }
    lilv_node_free(audio);
    lilv_node_free(input);
    if (audio_in_.size() != 2 || audio_out_.size() != 2) throw std::runtime_error("not stereo");
  }

  [[nodiscard]] float* port(const std::string& symbol) const {
    LilvNode* const node = lilv_new_string(world_, symbol.c_str());
    const LilvPort* const found = lilv_plugin_get_port_by_symbol(plugin_, node);
    lilv_node_free(node);
    if (found == nullptr) throw std::runtime_error("no port " + symbol);
    return const_cast<float*>(&controls_[lilv_port_get_index(plugin_, found)]);
  }

  UridMap urids_;
  LilvWorld* world_;
  const LilvPlugin* plugin_ = nullptr;
  LilvInstance* instance_ = nullptr;
  std::vector<float> controls_;  // one for each port
  std::vector<std::uint32_t> audio_in_;
  std::vector<std::uint32_t> audio_out_;
};

}  // namespace

std::unique_ptr<HostedPlugin> host_lv2(const std::filesystem::path& bundle, int sample_rate_hz,
                                       Lv2Host host) {
  return std::make_unique<Lv2Plugin>(bundle, sample_rate_hz, host);
}

Waveform HostedPlugin::process(const Waveform& sound, std::ptrdiff_t block) {
  Waveform result(2, sound.samples(), sound.sample_rate_hz());
  for (std::ptrdiff_t at = 0; at < sound.samples(); at += block) {
    const float* const in[] = {sound.channel(0).data() + at, sound.channel(1).data() + at};
    float* const out[] = {result.channel(0).data() + at, result.channel(1).data() + at};
    process(in, out, std::min(block, sound.samples() - at));
  }
  return result;
}

}  // namespace earpoint::plugin
