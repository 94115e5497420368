#include "trace_arguments.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include <earpoint/error.h>

namespace earpoint {

/// Any text as a box and as a place: refused with InputError, or read, and then the box is a scene
/// and the place a place.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    Scene scene = parse_shoebox("--shoebox", text);
    check_scene(scene, "box");
    if (scene.mesh.triangles.size() != 12) std::abort();
  } catch (const InputError&) {
  }
  try {
    const Pose pose = parse_pose("--camera", text);
    const Vector3& p = pose.position_m;
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) std::abort();
    const Vector3 ahead = rotate(pose.orientation, {1.0, 0.0, 0.0});
    if (!(std::abs(norm(ahead) - 1.0) < 1e-6)) std::abort();
  } catch (const InputError&) {
  }
  return 0;
}

}  // namespace earpoint
