#include "served_upload.h"

#include "speaker_search.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/platform/program_path.h>
#include <earpoint/core/progress.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>
#include <earpoint/render_files/picture_stream.h>
#include <earpoint/serve/limited_process.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUnpack = "unpack";
constexpr const char* kSound = "sound.wav";
constexpr const char* kPicture = "picture.png";
constexpr std::ptrdiff_t kBlock = 65536;  // samples read at once

/// Boxes of everybody in the picture of the clip's middle.
std::vector<SeenPerson> people_in(const PeopleInClip& people, double middle_s) {
  const auto frame = std::ranges::min_element(
      people.frames, {}, [&](const PeopleFrame& f) { return std::abs(f.time_s - middle_s); });
  const std::optional<int> speaker = summary_of(people).speaker;
  std::vector<SeenPerson> seen;
  for (const TrackedPerson& person : frame->people) {
    seen.push_back({person.box, person.track == speaker});
  }
  return seen;
}

void unpack(const fs::path& file, const fs::path& folder) {
  SourceArguments arguments;
  arguments.inputs = {file.string()};
  const RenderInput source = parse_source(arguments);
  const SoundSurvey survey = survey_sound(source.sound);
  if (survey.duration_s() > kLongestServed_s) {
    throw InputError("the file",
                     fmt::format("lasts longer than {:.0f} minutes", kLongestServed_s / 60.0));
  }
  SoundWriter writer(folder / kSound, 2, survey.sample_rate_hz, SampleFormat::float32,
                     survey.samples);
  const BlockReader read = read_blocks(source.sound);
  for (Waveform block = read(kBlock); block.samples() > 0; block = read(kBlock)) {
    writer.write(block);
  }
  writer.close();
  PictureStream pictures = open_pictures(std::nullopt, source.sound.path);
  if (pictures.empty()) return;
  write_image(folder / kPicture, *pictures.nearest(0.5 * survey.duration_s()));
}

/// The child's line without the program's name and the file's, which its sender does not know.
std::string problem_of(const ProcessEnd& end, const fs::path& file) {
  std::string line = end.errors.substr(0, end.errors.find('\n'));
  const std::string start = fmt::format("earpoint: {}", file.string());
  const auto found = line.find(start);
  if (found != std::string::npos) line = line.substr(found + start.size());
  line.erase(0, line.find_first_not_of(": "));
  return line;
}

}  // namespace

ServedClip open_recording(const SourceArguments& arguments, const GtfWeights* finder,
                          const std::string& detector, bool quiet) {
  RenderInput source = parse_source(arguments);
  const double fov_rad = radians_from_degrees(fov_deg_of(arguments, source, !quiet));
  SilentProgress silent;
  StreamProgress stream(stderr);
  ProgressSink& progress = quiet ? static_cast<ProgressSink&>(silent) : stream;
  const SpeakerSearchResult search = search_speaker(
      arguments, {.horizontal_fov_rad = fov_rad, .detector = detector, .quiet = quiet}, source,
      progress);
  if (!quiet) tell_of_speaker(arguments, search, source);
  ServedClip clip = open_served_clip(source, finder, fov_rad, progress);
  if (search.people && search.people->has_picture) {
    clip.people = people_in(*search.people, 0.5 * clip.sound.duration_s());
  }
  for (std::string& line : lines_of(search, source)) clip.warnings.push_back(std::move(line));
  if (clip.picture && !arguments.fov_deg) {
    clip.warnings.push_back(
        fmt::format("field of view: {:.0f} degrees, from the file's lens data or assumed",
                    degrees_from_radians(fov_rad)));
  }
  return clip;
}

ServedClip open_upload(const fs::path& file, const std::string& name, const GtfWeights* finder,
                       const std::string& detector) {
  const fs::path folder = file.parent_path();
  const ProcessEnd end =
      run_limited(running_program(), {kUnpack, file.string(), folder.string()}, {});
  if (end.is_out_of_time) throw InputError(name, "takes too long to decode", "cut it");
  if (end.exit_code != 0) {
    const std::string problem = problem_of(end, file);
    throw InputError(name, end.exit_code == 2 && !problem.empty()
                               ? problem
                               : "cannot be decoded: it is damaged or too large");
  }
  SourceArguments arguments;
  if (fs::exists(folder / kPicture)) arguments.inputs.push_back((folder / kPicture).string());
  arguments.inputs.push_back((folder / kSound).string());
  ServedClip clip = open_recording(arguments, finder, detector, true);
  clip.name = name;
  clip.source.reset();  // its files are removed
  return clip;
}

void add_unpack_command(CLI::App& app) {
  struct Arguments {
    fs::path file;
    fs::path folder;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(kUnpack, "");
  command->group("");
  command->add_option("file", arguments->file)->required();
  command->add_option("folder", arguments->folder)->required();
  command->callback([arguments] { unpack(arguments->file, arguments->folder); });
}

}  // namespace earpoint
