// Lets the plugin write manifest.ttl and its own description into the current folder, by a function
// that DPF puts into LV2 plugins. Usage: lv2_generator PLUGIN.so
#include <cstdio>

#include <dlfcn.h>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  void* const plugin = ::dlopen(argv[1], RTLD_NOW);
  void* const found = plugin == nullptr ? nullptr : ::dlsym(plugin, "lv2_generate_ttl");
  if (found == nullptr) {
    std::fprintf(stderr, "lv2_generator: %s\n", ::dlerror());
    return 1;
  }
  reinterpret_cast<void (*)(const char*)>(found)("earpoint");
  return 0;
}
