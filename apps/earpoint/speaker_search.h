#pragma once

#include "source_arguments.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <earpoint/core/progress.h>
#include <earpoint/locate/find_people.h>
#include <earpoint/locate/people_detector.h>

namespace earpoint {

/// Which detector --detector means, under the heading "Who speaks".
void add_detector_option(CLI::App& command, std::string& detector);

/// @param word   as --detector has it; empty: the shipped one
/// @param tells  say on stderr that none is shipped
/// @return null for "none", and where none is shipped
[[nodiscard]] std::unique_ptr<PeopleDetector> detector_named(const std::string& word, bool tells);

/// What is done about a recording before a model hears it.
struct SpeakerSearchRequest {
  double horizontal_fov_rad = 0.0;
  std::string detector;
  bool keeps_box = false;     ///< the model wants a box at every moment: the last one stays
  bool always_looks = false;  ///< for people, also where the speaker is given
  bool quiet = false;
};

/// What was found.
struct SpeakerSearchResult {
  StereoKind kind = StereoKind::plausible;  ///< what the recording is taken for
  bool is_placed = false;                   ///< its voice was put at the speaker
  std::optional<PeopleInClip> people;       ///< nothing where nobody was looked for
};

/// Finds who speaks where nothing tells, and puts the voice of a recording that is not binaural at
/// the speaker. Changes `source` accordingly.
/// @throws InputError as find_people() and survey_sound()
[[nodiscard]] SpeakerSearchResult search_speaker(const SourceArguments& arguments,
                                                 const SpeakerSearchRequest& request,
                                                 RenderInput& source, ProgressSink& progress);

/// Who was found, how sure that is, and what became of the recording: a line each, for people.
[[nodiscard]] std::vector<std::string> lines_of(const SpeakerSearchResult& result,
                                                const RenderInput& source);

/// Says on stderr who was found, how sure that is, and what became of the recording.
void tell_of_speaker(const SourceArguments& arguments, const SpeakerSearchResult& result,
                     const RenderInput& source);

/// What programs are told of it: "detector", "people", "speaker", "certainty", "outside".
[[nodiscard]] nlohmann::json json_of(const PeopleInClip& people);

}  // namespace earpoint
