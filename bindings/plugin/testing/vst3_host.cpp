#include "hosted_plugin.h"

#include <cctype>
#include <map>
#include <stdexcept>

#include <dlfcn.h>
#include <sys/utsname.h>

#include <travesty/audio_processor.h>
#include <travesty/component.h>
#include <travesty/edit_controller.h>
#include <travesty/factory.h>

namespace earpoint::plugin {
namespace {

/// DPF's own parameters come first: the latency.
constexpr v3_param_id kOwnParameters = 1;
constexpr std::int32_t kLongestBlock = 1 << 20;

v3_result no_interface(void*, const v3_tuid, void**) { return V3_NO_INTERFACE; }
std::uint32_t one(void*) { return 1; }
constexpr v3_funknown kUnknown{no_interface, one, one};

/// One new value of a parameter, at the block's start, as an object of VST3: first a pointer to
/// functions.
struct ValueQueue {
  struct Functions {
    v3_funknown unknown;
    v3_param_value_queue queue;
  };
  static v3_param_id get_id(void* self) { return static_cast<ValueQueue*>(self)->id; }
  static std::int32_t get_count(void*) { return 1; }
  static v3_result get_point(void* self, std::int32_t, std::int32_t* offset, double* value) {
    *offset = 0;
    *value = static_cast<ValueQueue*>(self)->normalized;
    return V3_OK;
  }
  static v3_result add_point(void* self, std::int32_t, double value, std::int32_t*) {
    static_cast<ValueQueue*>(self)->normalized = value;
    return V3_OK;
  }
  static constexpr Functions kFunctions{kUnknown, {get_id, get_count, get_point, add_point}};

  const Functions* functions = &kFunctions;
  v3_param_id id = 0;
  double normalized = 0.0;
};

/// The new values of a block.
struct Changes {
  struct Functions {
    v3_funknown unknown;
    v3_param_changes changes;
  };
  static v3_param_value_queue** as_queue(ValueQueue& queue) {
    return reinterpret_cast<v3_param_value_queue**>(&queue);
  }
  static std::int32_t get_count(void* self) {
    return static_cast<std::int32_t>(static_cast<Changes*>(self)->queues.size());
  }
  static v3_param_value_queue** get_data(void* self, std::int32_t index) {
    return as_queue(static_cast<Changes*>(self)->queues[static_cast<std::size_t>(index)]);
  }
  static v3_param_value_queue** add_data(void* self, v3_param_id* id, std::int32_t* index) {
    auto& queues = static_cast<Changes*>(self)->queues;
    *index = static_cast<std::int32_t>(queues.size());
    ValueQueue& queue = queues.emplace_back();
    queue.id = *id;
    return as_queue(queue);
  }
  static constexpr Functions kFunctions{kUnknown, {get_count, get_data, add_data}};

  const Functions* functions = &kFunctions;
  std::vector<ValueQueue> queues;
};

class Vst3Plugin : public HostedPlugin {
 public:
  Vst3Plugin(const std::filesystem::path& bundle, int sample_rate_hz)
      : library_(::dlopen(binary_of(bundle).c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (library_ == nullptr) throw std::runtime_error(::dlerror());
    if (!function<bool (*)(void*)>("ModuleEntry")(library_)) throw std::runtime_error("no module");
    auto** const factory = static_cast<v3_plugin_factory**>(
        const_cast<void*>(function<const void* (*)()>("GetPluginFactory")()));
    v3_class_info info{};
    check(v3_cpp_obj(factory)->get_class_info(factory, 0, &info), "class");
    void* made = nullptr;
    check(v3_cpp_obj(factory)->create_instance(factory, info.class_id, v3_component_iid, &made),
          "component");
    component_ = static_cast<v3_component**>(made);
    check(v3_cpp_obj_initialize(component_, nullptr), "initialize");
    check(v3_cpp_obj_query_interface(component_, v3_audio_processor_iid, &processor_), "processor");
    check(v3_cpp_obj_query_interface(component_, v3_edit_controller_iid, &controller_),
          "controller");
    v3_process_setup setup{V3_REALTIME, V3_SAMPLE_32, kLongestBlock,
                           static_cast<double>(sample_rate_hz)};
    check(v3_cpp_obj(processor_)->setup_processing(processor_, &setup), "setup");
    for (const v3_bus_direction way : {V3_INPUT, V3_OUTPUT}) {
      check(v3_cpp_obj(component_)->activate_bus(component_, V3_AUDIO, way, 0, true), "bus");
    }
    told_.queues.reserve(kParameterCount + kOwnParameters);
    start(true);
  }
  ~Vst3Plugin() override {
    start(false);
    v3_cpp_obj_unref(controller_);
    v3_cpp_obj_unref(processor_);
    v3_cpp_obj_terminate(component_);
    v3_cpp_obj_unref(component_);
    function<bool (*)()>("ModuleExit")();
    ::dlclose(library_);
  }
  Vst3Plugin(const Vst3Plugin&) = delete;
  Vst3Plugin& operator=(const Vst3Plugin&) = delete;

  void set(ParameterId id, double value) override {
    const v3_param_id number = kOwnParameters + id;
    ValueQueue& queue = changes_.queues.emplace_back();
    queue.id = number;
    queue.normalized =
        v3_cpp_obj(controller_)->plain_parameter_to_normalised(controller_, number, value);
  }
  [[nodiscard]] double get(ParameterId id) const override {
    const v3_param_id number = kOwnParameters + id;
    const auto& functions = *v3_cpp_obj(controller_);
    return functions.normalised_parameter_to_plain(
        controller_, number, functions.get_parameter_normalised(controller_, number));
  }

  [[nodiscard]] std::vector<std::string> model_names() const override {
    std::vector<std::string> names;
    const v3_param_id number = kOwnParameters + kModel;
    for (int model = 0; model < kMostModels; ++model) {
      v3_str_128 text{};
      const auto& functions = *v3_cpp_obj(controller_);
      const double normalized = functions.plain_parameter_to_normalised(controller_, number, model);
      functions.get_parameter_string_for_value(controller_, number, normalized, text);
      std::string name;
      for (const std::int16_t* at = text; *at != 0; ++at) name += static_cast<char>(*at);
      if (name.empty() || std::isdigit(static_cast<unsigned char>(name[0])) != 0) break;
      names.push_back(name);
    }
    return names;
  }

  void process(const float* const* in, float* const* out, std::ptrdiff_t frames) override {
    float* ins[] = {const_cast<float*>(in[0]), const_cast<float*>(in[1])};
    float* outs[] = {out[0], out[1]};
    v3_audio_bus_buffers input{2, 0, {ins}};
    v3_audio_bus_buffers output{2, 0, {outs}};
    told_.queues.clear();
    v3_process_data data{};
    data.process_mode = V3_REALTIME;
    data.symbolic_sample_size = V3_SAMPLE_32;
    data.nframes = static_cast<std::int32_t>(frames);
    data.num_input_buses = data.num_output_buses = 1;
    data.inputs = &input;
    data.outputs = &output;
    data.input_params = reinterpret_cast<v3_param_changes**>(&changes_);
    data.output_params = reinterpret_cast<v3_param_changes**>(&told_);
    check(v3_cpp_obj(processor_)->process(processor_, &data), "process");
    changes_.queues.clear();
  }
  [[nodiscard]] std::ptrdiff_t latency_samples() const override {
    return v3_cpp_obj(processor_)->get_latency_samples(processor_);
  }
  void restart() override {
    start(false);
    start(true);
  }

 private:
  static std::string binary_of(const std::filesystem::path& bundle) {
    utsname machine{};
    ::uname(&machine);
    const std::string name = bundle.stem().string() + ".so";
    return (bundle / "Contents" / (std::string(machine.machine) + "-linux") / name).string();
  }
  static void check(v3_result result, const char* what) {
    if (result != V3_OK) throw std::runtime_error(std::string("VST3 refuses: ") + what);
  }
  template <class Function>
  [[nodiscard]] Function function(const char* name) const {
    void* const found = ::dlsym(library_, name);
    if (found == nullptr) throw std::runtime_error(std::string("no function ") + name);
    return reinterpret_cast<Function>(found);
  }
  void start(bool on) {
    if (on) check(v3_cpp_obj(component_)->set_active(component_, true), "active");
    v3_cpp_obj(processor_)->set_processing(processor_, on);
    if (!on) v3_cpp_obj(component_)->set_active(component_, false);
  }

  void* library_;
  v3_component** component_ = nullptr;
  v3_audio_processor** processor_ = nullptr;
  v3_edit_controller** controller_ = nullptr;
  Changes changes_;
  Changes told_;  // what the plugin tells
};

}  // namespace

std::unique_ptr<HostedPlugin> host_vst3(const std::filesystem::path& bundle, int sample_rate_hz) {
  return std::make_unique<Vst3Plugin>(bundle, sample_rate_hz);
}

}  // namespace earpoint::plugin
