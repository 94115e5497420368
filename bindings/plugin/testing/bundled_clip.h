#pragma once

#include <filesystem>
#include <string>

#include <earpoint/waveform.h>

#include "live_renderer.h"

namespace earpoint::plugin {

/// The sound of examples/clip.mp4, 48 kHz, decoded by ffmpeg. The speaker of that clip stands
/// still.
[[nodiscard]] const Waveform& bundled_clip();

/// The first earpoint of examples/earpoints.json, and that clip's speaker, in single precision as
/// hosts have it.
[[nodiscard]] Settings bundled_settings();

/// What a stream of the library gives for a whole sound with these settings.
/// @param model  as Renderer::open() takes it
[[nodiscard]] Waveform stream_of_library(const std::string& model, const Settings& settings,
                                         const Waveform& sound);

/// Runs a command.
/// @return what it wrote, to both outputs
/// @throws std::runtime_error with that if it fails
std::string run_command(const std::string& command);

/// A program's path, or empty if it is not installed.
[[nodiscard]] std::string find_program(const std::string& name);

/// Samples from `start` on.
[[nodiscard]] Waveform part_of(const Waveform& sound, std::ptrdiff_t start, std::ptrdiff_t samples);

/// The same samples, bit for bit.
[[nodiscard]] bool same(const Waveform& a, const Waveform& b);

/// `sound`, that many samples later.
[[nodiscard]] Waveform delayed(const Waveform& sound, std::ptrdiff_t samples);

}  // namespace earpoint::plugin
