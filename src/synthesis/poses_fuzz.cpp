#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include <earpoint/error.h>
#include <earpoint/synthesis/earpoint_path.h>
#include <earpoint/synthesis/speaker_track.h>

namespace {

void require_finite(const earpoint::Pose& pose) {
  const earpoint::Vector3& p = pose.position_m;
  for (const double value : {p.x, p.y, p.z, pose.orientation.w, pose.orientation.z}) {
    if (!std::isfinite(value)) std::abort();
  }
}

}  // namespace

/// The first byte chooses the reader: poses as JSON, a path as CSV, boxes as CSV. Any text is
/// refused with InputError, or gives finite poses and boxes within the picture at any time.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace earpoint;  // NOLINT(google-build-using-namespace): one function
  if (size == 0) return 0;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  try {
    switch (data[0]) {
      case 'j':
        for (const Pose& pose : parse_poses_json(text, "input")) require_finite(pose);
        break;
      case 'p': {
        const EarpointPath path = EarpointPath::parse_csv(text, "input");
        for (const double time_s : {-1.0, 0.0, 0.3, 1e9}) require_finite(path.at(time_s));
        path.check_covers(10.0);
        break;
      }
      case 'b': {
        const SpeakerTrack track = SpeakerTrack::parse_csv(text, "input");
        const std::optional<Box> box = track.at(0.5);
        if (box && !(box->x_min >= 0.0 && box->x_max <= 1.0 && box->x_min < box->x_max)) {
          std::abort();
        }
        break;
      }
      default:
        break;
    }
  } catch (const InputError&) {
    return 0;
  }
  return 0;
}
