#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <earpoint/render_files/render.h>

namespace earpoint {

/// What the command line says of a recording: its files, its camera, who speaks.
struct SourceArguments {
  std::vector<std::string> inputs;
  std::string speaker;
  std::string speaker_box;
  std::string speaker_boxes;
  std::string binaural_channels;
  std::optional<int> audio_stream;
  std::optional<double> fov_deg;
  std::string recording = "auto";  ///< auto, binaural, stereo or mono
};

/// A movie, a sound, or a picture and a sound in either order; required.
CLI::Option* add_source_inputs(CLI::App& command, SourceArguments& arguments);
/// Boxes and the field of view, under the heading "Who speaks".
void add_box_options(CLI::App& command, SourceArguments& arguments);
/// Which stream and which channels of it.
void add_channel_option(CLI::App& command, SourceArguments& arguments);

/// What kind of recording it is, where that is not to be found out.
void add_recording_option(CLI::App& command, SourceArguments& arguments);

/// Mono sound is taken as both ears, unless --recording asks for binaural sound.
/// @throws InputError naming the flag or file
[[nodiscard]] RenderInput parse_source(const SourceArguments& arguments);

/// The camera's horizontal field of view: as --fov says, else as the picture's file tells, else 90
/// degrees.
/// @param tells  say on stderr which of the latter two it is, if there is a picture
[[nodiscard]] double fov_deg_of(const SourceArguments& arguments, const RenderInput& source,
                                bool tells);

/// Whether both ears are the same channel of the file.
[[nodiscard]] bool is_one_channel(const SoundInput& sound);

/// Whether there is a still or moving picture.
[[nodiscard]] bool has_picture_of(const RenderInput& source);

/// The picture's size in pixels, where there is one that tells it.
[[nodiscard]] SpeakerTrack::PictureSize picture_size_of(const RenderInput& source);

/// Says on stderr what the survey warns of.
void print_warnings(const SourceArguments& arguments, const SoundSurvey& survey);

}  // namespace earpoint
