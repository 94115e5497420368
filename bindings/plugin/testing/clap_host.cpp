#include "hosted_plugin.h"

#include <array>
#include <cstring>
#include <stdexcept>
#include <string_view>

#include <clap/entry.h>
#include <clap/ext/latency.h>
#include <clap/ext/params.h>
#include <clap/ext/state.h>
#include <clap/plugin-factory.h>
#include <dlfcn.h>

namespace earpoint::plugin {
namespace {

constexpr std::uint32_t kLongestBlock = 1U << 20;

class ClapPlugin : public HostedPlugin {
 public:
  ClapPlugin(const std::filesystem::path& file, int sample_rate_hz)
      : library_(::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)), rate_hz_(sample_rate_hz) {
    if (library_ == nullptr) throw std::runtime_error(::dlerror());
    entry_ = static_cast<const clap_plugin_entry_t*>(::dlsym(library_, "clap_entry"));
    if (entry_ == nullptr || !entry_->init(file.c_str()))
      throw std::runtime_error("no CLAP plugin");
    const auto* factory =
        static_cast<const clap_plugin_factory_t*>(entry_->get_factory(CLAP_PLUGIN_FACTORY_ID));
    if (factory->get_plugin_count(factory) != 1) throw std::runtime_error("not one plugin");
    const char* const id = factory->get_plugin_descriptor(factory, 0)->id;
    plugin_ = factory->create_plugin(factory, &host_, id);
    if (plugin_ == nullptr || !plugin_->init(plugin_))
      throw std::runtime_error("it does not start");
    start();
  }
  ~ClapPlugin() override {
    stop();
    plugin_->destroy(plugin_);
    entry_->deinit();
    ::dlclose(library_);
  }
  ClapPlugin(const ClapPlugin&) = delete;
  ClapPlugin& operator=(const ClapPlugin&) = delete;

  void set(ParameterId id, double value) override {
    clap_event_param_value_t event{};
    event.header = {.size = sizeof(event),
                    .time = 0,
                    .space_id = CLAP_CORE_EVENT_SPACE_ID,
                    .type = CLAP_EVENT_PARAM_VALUE,
                    .flags = 0};
    event.param_id = id;
    event.note_id = event.port_index = event.channel = event.key = -1;
    event.value = value;
    events_.push_back(event);
  }
  [[nodiscard]] double get(ParameterId id) const override {
    double value = 0.0;
    if (!params().get_value(plugin_, id, &value)) throw std::runtime_error("no such parameter");
    return value;
  }

  [[nodiscard]] std::vector<std::string> model_names() const override {
    std::vector<std::string> names;
    std::array<char, 64> text{};
    for (int number = 0; number < kMostModels; ++number) {
      if (!params().value_to_text(plugin_, kModel, number, text.data(), text.size())) break;
      if (text[0] >= '0' && text[0] <= '9') break;  // a number without a name
      names.emplace_back(text.data());
    }
    return names;
  }

  void process(const float* const* in, float* const* out, std::ptrdiff_t frames) override {
    float* ins[] = {const_cast<float*>(in[0]), const_cast<float*>(in[1])};
    float* outs[] = {out[0], out[1]};
    const clap_audio_buffer_t input{ins, nullptr, 2, 0, 0};
    clap_audio_buffer_t output{outs, nullptr, 2, 0, 0};
    const clap_input_events_t in_events{&events_, count_events, event_at};
    const clap_output_events_t out_events{
        nullptr, [](const clap_output_events_t*, const clap_event_header_t*) { return true; }};
    clap_process_t process{};
    process.steady_time = -1;
    process.frames_count = static_cast<std::uint32_t>(frames);
    process.audio_inputs = &input;
    process.audio_outputs = &output;
    process.audio_inputs_count = process.audio_outputs_count = 1;
    process.in_events = &in_events;
    process.out_events = &out_events;
    if (plugin_->process(plugin_, &process) == CLAP_PROCESS_ERROR) {
      throw std::runtime_error("the plugin reports an error");
    }
    events_.clear();
  }

  [[nodiscard]] std::ptrdiff_t latency_samples() const override {
    return extension<clap_plugin_latency_t>(CLAP_EXT_LATENCY).get(plugin_);
  }
  void restart() override {
    stop();
    start();
  }
  [[nodiscard]] int restart_requests() const override { return restart_requests_; }

  [[nodiscard]] std::string save() const {
    std::string state;
    const clap_ostream_t stream{
        &state, [](const clap_ostream_t* to, const void* bytes, std::uint64_t count) {
          static_cast<std::string*>(to->ctx)->append(static_cast<const char*>(bytes), count);
          return static_cast<std::int64_t>(count);
        }};
    if (!extension<clap_plugin_state_t>(CLAP_EXT_STATE).save(plugin_, &stream)) {
      throw std::runtime_error("the state is not saved");
    }
    return state;
  }
  void load(const std::string& state) {
    std::string_view rest = state;
    const clap_istream_t stream{
        &rest, [](const clap_istream_t* from, void* bytes, std::uint64_t count) {
          auto& left = *static_cast<std::string_view*>(from->ctx);
          const std::size_t taken = left.copy(static_cast<char*>(bytes), count);
          left.remove_prefix(taken);
          return static_cast<std::int64_t>(taken);
        }};
    if (!extension<clap_plugin_state_t>(CLAP_EXT_STATE).load(plugin_, &stream)) {
      throw std::runtime_error("the state is not loaded");
    }
  }

 private:
  static std::uint32_t count_events(const clap_input_events_t* list) {
    return static_cast<std::uint32_t>(
        static_cast<const std::vector<clap_event_param_value_t>*>(list->ctx)->size());
  }
  static const clap_event_header_t* event_at(const clap_input_events_t* list, std::uint32_t index) {
    return &(*static_cast<const std::vector<clap_event_param_value_t>*>(list->ctx))[index].header;
  }

  template <class Extension>
  [[nodiscard]] const Extension& extension(const char* id) const {
    const void* const found = plugin_->get_extension(plugin_, id);
    if (found == nullptr) throw std::runtime_error(std::string("no extension ") + id);
    return *static_cast<const Extension*>(found);
  }
  [[nodiscard]] const clap_plugin_params_t& params() const {
    return extension<clap_plugin_params_t>(CLAP_EXT_PARAMS);
  }

  void start() {
    if (!plugin_->activate(plugin_, rate_hz_, 1, kLongestBlock) ||
        !plugin_->start_processing(plugin_)) {
      throw std::runtime_error("the CLAP plugin is not activated");
    }
  }
  void stop() {
    plugin_->stop_processing(plugin_);
    plugin_->deactivate(plugin_);
  }

  static const void* host_extension(const clap_host_t*, const char* id) {
    static const clap_host_latency_t latency{[](const clap_host_t*) {}};
    return std::strcmp(id, CLAP_EXT_LATENCY) == 0 ? &latency : nullptr;
  }
  static void request_restart(const clap_host_t* host) {
    ++static_cast<ClapPlugin*>(host->host_data)->restart_requests_;
  }

  void* library_;
  int rate_hz_;
  clap_host_t host_{CLAP_VERSION,
                    this,
                    "Earpoint's tests",
                    "Earpoint",
                    "",
                    "1",
                    host_extension,
                    request_restart,
                    [](const clap_host_t*) {},
                    [](const clap_host_t*) {}};
  const clap_plugin_entry_t* entry_ = nullptr;
  const clap_plugin_t* plugin_ = nullptr;
  std::vector<clap_event_param_value_t> events_;
  int restart_requests_ = 0;
};

}  // namespace

std::unique_ptr<HostedPlugin> host_clap(const std::filesystem::path& file, int sample_rate_hz) {
  return std::make_unique<ClapPlugin>(file, sample_rate_hz);
}

std::string save_clap_state(HostedPlugin& plugin) {
  return dynamic_cast<ClapPlugin&>(plugin).save();
}

void load_clap_state(HostedPlugin& plugin, const std::string& state) {
  dynamic_cast<ClapPlugin&>(plugin).load(state);
}

}  // namespace earpoint::plugin
