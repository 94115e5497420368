#include "source_arguments.h"

#include "arguments.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/media/media.h>

namespace earpoint {
namespace {

constexpr const char* kSpeakerGroup = "Speaker";

bool is_picture(const std::filesystem::path& path) {
  return probe_media(path).kind == MediaKind::picture;
}

/// The picture that goes with the sound; nothing if there is none.
std::optional<StreamInfo> picture_of(const RenderInput& source) {
  const MediaInfo info = probe_media(source.picture.value_or(source.sound.path));
  const StreamInfo* picture = info.preferred(StreamKind::video);
  return picture == nullptr ? std::nullopt : std::optional(*picture);
}

/// Whether the stream that is heard has one channel.
bool is_mono(const SoundInput& sound) {
  const MediaInfo info = probe_media(sound.path);
  if (!sound.audio_stream) {
    const StreamInfo* preferred = info.preferred(StreamKind::audio);
    return preferred != nullptr && preferred->channels == 1;
  }
  return std::ranges::any_of(info.streams, [&](const StreamInfo& stream) {
    return stream.index == *sound.audio_stream && stream.kind == StreamKind::audio &&
           stream.channels == 1;
  });
}

SpeakerTrack::PictureSize picture_size(const std::optional<StreamInfo>& picture) {
  if (!picture || picture->width <= 0 || picture->height <= 0) return std::nullopt;
  return std::array{picture->width, picture->height};
}

}  // namespace

CLI::Option* add_source_inputs(CLI::App& command, SourceArguments& arguments) {
  return command
      .add_option("inputs", arguments.inputs,
                  "A movie, a sound file, or a picture and a sound file; - is standard input")
      ->required()
      ->expected(1, 2);
}

void add_box_options(CLI::App& command, SourceArguments& arguments) {
  auto* box = command
                  .add_option("--speaker-box", arguments.speaker_box,
                              "x0,y0,x1,y1 of the speaker in the picture, 0 to 1 from top left, or "
                              "in pixels")
                  ->group(kSpeakerGroup);
  command.add_option("--speaker-boxes", arguments.speaker_boxes, "CSV file with boxes over time")
      ->group(kSpeakerGroup)
      ->excludes(box);
  command
      .add_option(
          "--fov", arguments.fov_deg,
          "The camera's horizontal field of view, degrees; default: from the lens data of the "
          "picture's file, else 90")
      ->check(within(10.0, 170.0))
      ->group(kSpeakerGroup);
}

void add_channel_option(CLI::App& command, SourceArguments& arguments) {
  command.add_option("--binaural-channels", arguments.binaural_channels,
                     "left,right: the channel of each ear, counted from 0");
  command.add_option("--audio-stream", arguments.audio_stream,
                     "Audio stream of a movie, counted from 0; default: the preferred one");
}

void add_recording_option(CLI::App& command, SourceArguments& arguments) {
  command
      .add_option(
          "--recording", arguments.recording,
          "Kind of recording: binaural, stereo (phone or mixing desk) or mono; for the latter two "
          "the voice is placed at the speaker by head filters; auto detects it")
      ->check(CLI::IsMember({"auto", "binaural", "stereo", "mono"}))
      ->capture_default_str();
}

bool is_one_channel(const SoundInput& sound) {
  return sound.binaural_channels && (*sound.binaural_channels)[0] == (*sound.binaural_channels)[1];
}

bool has_picture_of(const RenderInput& source) { return picture_of(source).has_value(); }

SpeakerTrack::PictureSize picture_size_of(const RenderInput& source) {
  return picture_size(picture_of(source));
}

RenderInput parse_source(const SourceArguments& arguments) {
  RenderInput source;
  source.sound.path = stored_input(arguments.inputs.back());
  if (arguments.inputs.size() == 2) {
    source.picture = stored_input(arguments.inputs.front());
    if (is_picture(source.sound.path) && !is_picture(*source.picture)) {
      std::swap(*source.picture, source.sound.path);
    }
  }
  if (is_picture(source.sound.path)) {
    throw InputError(source.sound.path.string(), "is a picture without sound",
                     "give its sound too: frame.png sound.flac");
  }
  source.sound.audio_stream = arguments.audio_stream;
  if (!arguments.binaural_channels.empty()) {
    const auto channels = parse_numbers(arguments.binaural_channels, 2, "--binaural-channels");
    source.sound.binaural_channels = {static_cast<int>(channels[0]), static_cast<int>(channels[1])};
  }
  if (!source.sound.binaural_channels && arguments.recording != "binaural" &&
      is_mono(source.sound)) {
    source.sound.binaural_channels = {0, 0};
  }
  if (!arguments.speaker.empty()) {
    source.speaker_m = parse_place(arguments.speaker, "--speaker");
  }
  if (!arguments.speaker_box.empty()) {
    const auto box = parse_numbers(arguments.speaker_box, 4, "--speaker-box");
    source.speaker_track =
        SpeakerTrack(Box{box[0], box[1], box[2], box[3]}, picture_size(picture_of(source)));
  }
  if (!arguments.speaker_boxes.empty()) {
    source.speaker_track =
        SpeakerTrack::from_csv(arguments.speaker_boxes, picture_size(picture_of(source)));
  }
  return source;
}

double fov_deg_of(const SourceArguments& arguments, const RenderInput& source, bool tells) {
  constexpr double kAssumedDegrees = 90.0;
  if (arguments.fov_deg) return *arguments.fov_deg;
  const std::optional<StreamInfo> picture = picture_of(source);
  if (!picture) return kAssumedDegrees;
  const std::string& name = arguments.inputs.front();
  if (picture->horizontal_fov_rad) {
    const double fov_deg =
        std::clamp(degrees_from_radians(*picture->horizontal_fov_rad), 10.0, 170.0);
    if (tells) {
      fmt::print(stderr, "earpoint: {}: field of view {:.0f} degrees, from its lens data\n", name,
                 fov_deg);
    }
    return fov_deg;
  }
  if (tells) {
    fmt::print(stderr,
               "earpoint: {}: field of view unknown, 90 degrees assumed; use --fov to set it\n",
               name);
  }
  return kAssumedDegrees;
}

void print_warnings(const SourceArguments& arguments, const SoundSurvey& survey) {
  for (const std::string& warning : survey.warnings) {
    fmt::print(stderr, "earpoint: warning: {}: {}\n", arguments.inputs.back(), warning);
  }
}

}  // namespace earpoint
