#include "source_arguments.h"

#include "arguments.h"

#include <filesystem>
#include <utility>

#include <earpoint/core/error.h>
#include <earpoint/video/media.h>

namespace earpoint {
namespace {

constexpr const char* kSpeakerGroup = "Who speaks";

bool is_picture(const std::filesystem::path& path) {
  return probe_media(path).kind == MediaKind::picture;
}

}  // namespace

void add_source_inputs(CLI::App& command, SourceArguments& arguments) {
  command
      .add_option("inputs", arguments.inputs,
                  "A movie, a sound file, or a picture and a sound file")
      ->required()
      ->expected(1, 2);
}

void add_box_options(CLI::App& command, SourceArguments& arguments) {
  auto* box = command
                  .add_option("--speaker-box", arguments.speaker_box,
                              "x0,y0,x1,y1 of the person in the picture, 0 to 1 from top left")
                  ->group(kSpeakerGroup);
  command.add_option("--speaker-boxes", arguments.speaker_boxes, "CSV file with boxes over time")
      ->group(kSpeakerGroup)
      ->excludes(box);
  command.add_option("--fov", arguments.fov_deg, "The camera's horizontal field of view, degrees")
      ->check(within(10.0, 170.0))
      ->capture_default_str()
      ->group(kSpeakerGroup);
}

void add_channel_option(CLI::App& command, SourceArguments& arguments) {
  command.add_option("--binaural-channels", arguments.binaural_channels,
                     "left,right: which channels are the ears, counted from 0");
}

RenderSource parse_source(const SourceArguments& arguments) {
  RenderSource source;
  source.sound.path = arguments.inputs.back();
  if (arguments.inputs.size() == 2) {
    source.picture = arguments.inputs.front();
    if (is_picture(source.sound.path) && !is_picture(*source.picture)) {
      std::swap(*source.picture, source.sound.path);
    }
  }
  if (is_picture(source.sound.path)) {
    throw InputError(source.sound.path.string(), "is a picture without sound",
                     "give its sound too: frame.png sound.flac");
  }
  if (!arguments.binaural_channels.empty()) {
    const auto channels = parse_numbers(arguments.binaural_channels, 2, "--binaural-channels");
    source.sound.binaural_channels = {static_cast<int>(channels[0]), static_cast<int>(channels[1])};
  }
  if (!arguments.speaker.empty()) {
    source.speaker_m = parse_place(arguments.speaker, "--speaker");
  }
  if (!arguments.speaker_box.empty()) {
    const auto box = parse_numbers(arguments.speaker_box, 4, "--speaker-box");
    source.speaker_track = SpeakerTrack(Box{box[0], box[1], box[2], box[3]});
  }
  if (!arguments.speaker_boxes.empty()) {
    source.speaker_track = SpeakerTrack::from_csv(arguments.speaker_boxes);
  }
  return source;
}

}  // namespace earpoint
