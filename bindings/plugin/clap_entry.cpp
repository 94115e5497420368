// The CLAP entry: DPF's, which however asks the host to restart the plugin with its first block, as
// it notices only then that there is a latency. Deactivated once before, it has told the host.
#include <clap/entry.h>
#include <clap/plugin-factory.h>

#include <cstring>

// NOLINTNEXTLINE(readability-identifier-naming): the build calls DPF's so.
extern "C" const clap_plugin_entry_t dpf_clap_entry;

namespace {

const clap_plugin_factory_t& dpf_factory() {
  return *static_cast<const clap_plugin_factory_t*>(
      dpf_clap_entry.get_factory(CLAP_PLUGIN_FACTORY_ID));
}

/// DPF's own, the same for every plugin.
bool (*dpf_activate)(const clap_plugin_t*, double, std::uint32_t, std::uint32_t) = nullptr;

bool activate(const clap_plugin_t* plugin, double sample_rate_hz, std::uint32_t fewest,
              std::uint32_t most) {
  if (!dpf_activate(plugin, sample_rate_hz, fewest, most)) return false;
  plugin->deactivate(plugin);
  return dpf_activate(plugin, sample_rate_hz, fewest, most);
}

const clap_plugin_t* create_plugin(const clap_plugin_factory_t*, const clap_host_t* host,
                                   const char* id) {
  const clap_plugin_t* const made = dpf_factory().create_plugin(&dpf_factory(), host, id);
  if (made == nullptr) return nullptr;
  dpf_activate = made->activate;
  // DPF keeps it in memory of its own, one for each plugin.
  const_cast<clap_plugin_t*>(made)->activate = activate;
  return made;
}

const void* get_factory(const char* id) {
  static const clap_plugin_factory_t factory{
      [](const clap_plugin_factory_t*) { return dpf_factory().get_plugin_count(&dpf_factory()); },
      [](const clap_plugin_factory_t*, std::uint32_t index) {
        return dpf_factory().get_plugin_descriptor(&dpf_factory(), index);
      },
      create_plugin};
  return std::strcmp(id, CLAP_PLUGIN_FACTORY_ID) == 0 ? &factory : nullptr;
}

}  // namespace

extern "C" CLAP_EXPORT const clap_plugin_entry_t clap_entry = {
    CLAP_VERSION, [](const char* path) { return dpf_clap_entry.init(path); },
    [] { dpf_clap_entry.deinit(); }, get_factory};
