// The LV2 entry: DPF's, for hosts too that tell neither block lengths nor numbers of names. DPF
// refuses these, and ffmpeg and lv2apply are such hosts. The plugin needs neither.
#include <cstdint>
#include <cstring>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include <lv2/atom/atom.h>
#include <lv2/buf-size/buf-size.h>
#include <lv2/core/lv2.h>
#include <lv2/options/options.h>
#include <lv2/urid/urid.h>

extern "C" const LV2_Descriptor* dpf_lv2_descriptor(std::uint32_t index);

namespace {

constexpr std::int32_t kUsualBlock = 8192;

/// Numbers for names, the same in the whole process.
LV2_URID number_of(LV2_URID_Map_Handle, const char* uri) {
  static std::mutex mutex;
  static std::map<std::string, LV2_URID> numbers;
  const std::scoped_lock lock(mutex);
  return numbers.emplace(uri, static_cast<LV2_URID>(numbers.size() + 1)).first->second;
}

template <class Data>
Data* find(const std::vector<const LV2_Feature*>& features, const char* uri) {
  for (const LV2_Feature* feature : features) {
    if (std::strcmp(feature->URI, uri) == 0) return static_cast<Data*>(feature->data);
  }
  return nullptr;
}

LV2_Handle instantiate(const LV2_Descriptor*, double sample_rate_hz, const char* bundle,
                       const LV2_Feature* const* given) {
  std::vector<const LV2_Feature*> features;
  for (; given != nullptr && *given != nullptr; ++given) features.push_back(*given);

  static LV2_URID_Map own_map{nullptr, number_of};  // the plugin keeps its address
  const LV2_Feature map_feature{LV2_URID__map, &own_map};
  auto* map = find<LV2_URID_Map>(features, LV2_URID__map);
  if (map == nullptr) {
    map = &own_map;
    features.push_back(&map_feature);
  }

  std::int32_t block = kUsualBlock;
  LV2_Options_Option options[] = {
      {LV2_OPTIONS_INSTANCE, 0, map->map(map->handle, LV2_BUF_SIZE__maxBlockLength), sizeof(block),
       map->map(map->handle, LV2_ATOM__Int), &block},
      {LV2_OPTIONS_INSTANCE, 0, 0, 0, 0, nullptr}};
  const LV2_Feature options_feature{LV2_OPTIONS__options, options};
  if (find<void>(features, LV2_OPTIONS__options) == nullptr) features.push_back(&options_feature);

  features.push_back(nullptr);
  const LV2_Descriptor* const dpf = dpf_lv2_descriptor(0);
  return dpf->instantiate(dpf, sample_rate_hz, bundle, features.data());
}

}  // namespace

LV2_SYMBOL_EXPORT const LV2_Descriptor* lv2_descriptor(std::uint32_t index) {
  if (index != 0) return nullptr;
  static const LV2_Descriptor descriptor = [] {
    LV2_Descriptor own = *dpf_lv2_descriptor(0);
    own.instantiate = instantiate;
    return own;
  }();
  return &descriptor;
}
