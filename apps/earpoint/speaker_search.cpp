#include "speaker_search.h"

#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <earpoint/error.h>
#include <earpoint/network/shipped_model.h>

namespace earpoint {
namespace {

constexpr const char* kShippedDetector = "people.safetensors";

StereoKind kind_of(const SourceArguments& arguments, const RenderInput& source,
                   const SoundSurvey& survey) {
  if (arguments.recording == "binaural") return StereoKind::plausible;
  if (arguments.recording == "mono") return StereoKind::same;
  if (arguments.recording == "stereo") {
    return survey.stereo == StereoKind::plausible ? StereoKind::panned : survey.stereo;
  }
  return is_one_channel(source.sound) ? StereoKind::same : survey.stereo;
}

std::optional<VoicePlacement> placement_of(const RenderInput& source, StereoKind kind,
                                           double horizontal_fov_rad) {
  if (source.speaker_m) return placed_at(*source.speaker_m, kind);
  if (!source.speaker_track) return std::nullopt;
  return placed_at(*source.speaker_track, kind, horizontal_fov_rad, picture_size_of(source));
}

const char* words_for(StereoKind kind) {
  switch (kind) {
    case StereoKind::plausible:
      return "binaural";
    case StereoKind::one_channel:
      return "only one channel has sound";
    case StereoKind::same:
      return "mono";
    case StereoKind::panned:
      return "panned stereo";
    case StereoKind::inverted:
      return "one channel is inverted";
  }
  EARPOINT_CHECK(false);
}

std::string side_of(double azimuth_rad) {
  const double azimuth_deg = degrees_from_radians(azimuth_rad);
  return fmt::format("{:.0f} degrees {}", std::abs(azimuth_deg),
                     azimuth_deg < 0 ? "right" : "left");
}

std::string who_speaks(const PeopleInClip& people) {
  const SpeakerSummary summary = summary_of(people);
  if (summary.people == 0) return "nobody is in the picture";
  const std::string found = fmt::format("{} {} in the picture", summary.people,
                                        summary.people == 1 ? "person" : "people");
  if (!people.hears_direction && summary.people > 1) {
    return found + "; the speaker among them cannot be found without binaural sound";
  }
  const std::string sure = fmt::format("{:.0f} % sure", 100.0 * summary.certainty);
  if (!summary.speaker) return fmt::format("{}; the speaker is not ({})", found, sure);
  return fmt::format("{}; number {} speaks ({})", found, *summary.speaker, sure);
}

}  // namespace

void add_detector_option(CLI::App& command, std::string& detector) {
  command
      .add_option(
          "--detector", detector,
          "People detector, used if no speaker is given: a weight file or an .onnx network; "
          "none: do not detect people; default: the shipped network")
      ->group("Speaker");
}

std::unique_ptr<PeopleDetector> detector_named(const std::string& word, bool tells) {
  if (word == "none") return nullptr;
  if (!word.empty()) return make_people_detector(word);
  if (const auto shipped = shipped_model_path(kShippedDetector)) {
    return make_people_detector(*shipped);
  }
  if (tells) {
    fmt::print(stderr,
               "earpoint: warning: {} is not among the shipped models, people are not detected; "
               "use --speaker or --speaker-box\n",
               kShippedDetector);
  }
  return nullptr;
}

SpeakerSearchResult search_speaker(const SourceArguments& arguments,
                                   const SpeakerSearchRequest& request, RenderInput& source,
                                   ProgressSink& progress) {
  SpeakerSearchResult result;
  source.survey = survey_sound(source.sound);
  const SoundSurvey& survey = *source.survey;
  result.kind = kind_of(arguments, source, survey);
  const bool is_told = source.speaker_track || source.speaker_m;
  const bool has_picture = has_picture_of(source);
  std::unique_ptr<PeopleDetector> detector;
  if (!is_told && has_picture) detector = detector_named(request.detector, !request.quiet);
  if (detector || request.always_looks) {
    const PeopleSearch search{.detector = detector.get(),
                              .horizontal_fov_rad = request.horizontal_fov_rad,
                              .hears_direction = result.kind == StereoKind::plausible};
    result.people = find_people(source, survey, search, progress);
    if (!is_told) source.speaker_track = speaker_track(*result.people);
    if (request.keeps_box && source.speaker_track) {
      source.speaker_track = source.speaker_track->held();
    }
  }
  if (result.kind != StereoKind::plausible) {
    auto placement = placement_of(source, result.kind, request.horizontal_fov_rad);
    result.is_placed = placement.has_value();
    if (placement) {
      source.sound.placement = std::make_shared<const VoicePlacement>(std::move(*placement));
      source.survey.reset();  // that of the sound before
    }
  }
  return result;
}

std::vector<std::string> lines_of(const SpeakerSearchResult& result, const RenderInput& source) {
  std::vector<std::string> lines;
  if (result.people && result.people->has_picture) {
    lines.push_back(
        fmt::format("{}, found by {}", who_speaks(*result.people), result.people->detector));
  }
  if (result.kind == StereoKind::plausible) return lines;
  if (!result.is_placed) {
    lines.push_back(
        fmt::format("not binaural ({}), and the speaker's position is unknown; "
                    "use --speaker x,y,z or --speaker-box",
                    words_for(result.kind)));
    return lines;
  }
  const Vector3 mouth = source.sound.placement->rows.front().mouth_m;
  lines.push_back(
      fmt::format("not binaural ({}): the voice is placed at the speaker, {}{}, by head filters; "
                  "use --recording binaural to keep it unchanged",
                  words_for(result.kind), side_of(std::atan2(mouth.y, mouth.x)),
                  source.sound.placement->rows.size() > 1 ? " at first" : ""));
  return lines;
}

void tell_of_speaker(const SourceArguments& arguments, const SpeakerSearchResult& result,
                     const RenderInput& source) {
  for (const std::string& line : lines_of(result, source)) {
    fmt::print(stderr, "earpoint: {}: {}\n", arguments.inputs.back(), line);
  }
}

nlohmann::json json_of(const PeopleInClip& people) {
  const SpeakerSummary summary = summary_of(people);
  nlohmann::json json{{"detector", people.detector},
                      {"people", summary.people},
                      {"speaker", nullptr},
                      {"certainty", summary.certainty},
                      {"outside", summary.outside_share}};
  if (summary.speaker) json["speaker"] = *summary.speaker;
  return json;
}

}  // namespace earpoint
