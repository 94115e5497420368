#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <earpoint/synth/render.h>

namespace earpoint {

/// What the command line says of a recording: its files, its camera, who speaks.
struct SourceArguments {
  std::vector<std::string> inputs;
  std::string speaker;
  std::string speaker_box;
  std::string speaker_boxes;
  std::string binaural_channels;
  double fov_deg = 90.0;
};

/// A movie, a sound, or a picture and a sound in either order.
void add_source_inputs(CLI::App& command, SourceArguments& arguments);
/// Boxes and the field of view, under the heading "Who speaks".
void add_box_options(CLI::App& command, SourceArguments& arguments);
void add_channel_option(CLI::App& command, SourceArguments& arguments);

/// @throws InputError naming the flag or file
[[nodiscard]] RenderSource parse_source(const SourceArguments& arguments);

}  // namespace earpoint
