#include <earpoint/scene/embree_config.h>

namespace earpoint {

const char* embree_config() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0) {
    return "threads=1,isa=avx2";
  }
#endif
  return "threads=1";
}

}  // namespace earpoint
