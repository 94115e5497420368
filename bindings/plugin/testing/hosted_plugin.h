#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <earpoint/waveform.h>

#include "model_search.h"
#include "parameters.h"

namespace earpoint::plugin {

/// A plugin that a small host of the tests has loaded, as workstations do it.
class HostedPlugin {
 public:
  virtual ~HostedPlugin() = default;

  /// Sets a parameter from the next block on. kBypass: 1 bypasses.
  virtual void set(ParameterId id, double value) = 0;
  /// The value after the last block.
  [[nodiscard]] virtual double get(ParameterId id) const = 0;
  /// Labels of the model's numbers from 0 on.
  [[nodiscard]] virtual std::vector<std::string> model_names() const = 0;

  virtual void process(const float* const* in, float* const* out, std::ptrdiff_t frames) = 0;
  /// As the host learns it: in LV2 after a block only.
  [[nodiscard]] virtual std::ptrdiff_t latency_samples() const = 0;
  /// Stops and starts it, as workstations do between takes.
  virtual void restart() = 0;
  /// How often the plugin has asked for that.
  [[nodiscard]] virtual int restart_requests() const { return 0; }

  /// A whole sound, in blocks of a size.
  [[nodiscard]] Waveform process(const Waveform& sound, std::ptrdiff_t block);
};

/// Which features the host has.
enum class Lv2Host {
  full,  ///< block lengths and numbers of names
  bare,  ///< neither, as ffmpeg and lv2apply
};

/// All throw std::runtime_error if the plugin does not load.
[[nodiscard]] std::unique_ptr<HostedPlugin> host_lv2(const std::filesystem::path& bundle,
                                                     int sample_rate_hz, Lv2Host host);
[[nodiscard]] std::unique_ptr<HostedPlugin> host_clap(const std::filesystem::path& file,
                                                      int sample_rate_hz);
[[nodiscard]] std::unique_ptr<HostedPlugin> host_vst3(const std::filesystem::path& bundle,
                                                      int sample_rate_hz);

/// The state that a CLAP host would keep in its session, and the same parameters in another plugin.
[[nodiscard]] std::string save_clap_state(HostedPlugin& plugin);
void load_clap_state(HostedPlugin& plugin, const std::string& state);

}  // namespace earpoint::plugin
