#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/serve/listen_method.h>
#include <earpoint/serve/served_clip.h>

namespace earpoint {

/// The recording, signal processing and the networks that come with Earpoint.
inline const std::vector<ListenMethod>& bundled_methods() {
  static const std::vector<ListenMethod> methods = [] {
    const std::string models = std::string(EARPOINT_SOURCE_DIR) + "/models/";
    return listen_methods(std::vector<std::string>{"input", "dsp",
                                                   "gtf=" + models + "gtf.safetensors",
                                                   "vigas=" + models + "vigas.safetensors"});
  }();
  return methods;
}

/// The clip that comes with Earpoint; its speaker is found.
inline std::shared_ptr<const ServedClip> bundled_clip() {
  static const auto clip = [] {
    RenderInput source;
    source.sound.path = std::filesystem::path(EARPOINT_SOURCE_DIR) / "examples/clip.mp4";
    SilentProgress silent;
    return std::make_shared<const ServedClip>(open_served_clip(
        source, bundled_methods()[2].gtf.get(), radians_from_degrees(90.0), silent));
  }();
  return clip;
}

/// The same, told where the speaker is seen and stands.
inline std::shared_ptr<const ServedClip> told_clip() {
  static const auto clip = [] {
    ServedClip told = *bundled_clip();
    told.speaker_box = Box{.x_min = 0.383, .y_min = 0.348, .x_max = 0.513, .y_max = 1.0};
    told.speaker_m = Vector3{1.89, 0.196, 0.147};
    return std::make_shared<const ServedClip>(std::move(told));
  }();
  return clip;
}

}  // namespace earpoint
