#pragma once

#include <filesystem>
#include <optional>

#include <earpoint/core/progress.h>
#include <earpoint/serve/served_clip.h>

namespace earpoint {

/// The clip and the network that come with Earpoint.
inline const ServedClip& bundled_clip() {
  static const ServedClip clip = [] {
    const std::filesystem::path folder = EARPOINT_SOURCE_DIR;
    RenderSource source;
    source.sound.path = folder / "examples/clip.mp4";
    SilentProgress silent;
    return open_served_clip(source, folder / "models/gtf.safetensors", radians_from_degrees(90.0),
                            silent);
  }();
  return clip;
}

}  // namespace earpoint
