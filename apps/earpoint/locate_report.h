#pragma once

#include "source_arguments.h"
#include "speaker_search.h"

#include <string>

#include <nlohmann/json_fwd.hpp>

#include <earpoint/core/progress.h>
#include <earpoint/render_files/locate_speaker.h>

namespace earpoint {

/// Which recording, and by which networks.
struct LocateRequest {
  SourceArguments source;
  std::string model;     ///< a name or a weight file; empty: the shipped one
  std::string detector;  ///< as --detector has it; empty: the shipped one
  bool quiet = false;    ///< say nothing on stderr
};

/// The people of a recording, who of them speaks, and where that is.
struct LocateResult {
  std::string model;  ///< the weight file
  double horizontal_fov_rad = 0.0;
  RenderInput source;  ///< as it was analysed
  PeopleInClip people;
  LocatedSpeaker speaker;
};

/// What `earpoint locate` does, before it prints.
/// @throws InputError for a bad recording, picture, box or model
[[nodiscard]] LocateResult locate(const LocateRequest& request, ProgressSink& progress);

/// What `earpoint locate --json` prints.
/// @param is_3d  distance, height and heading as well
[[nodiscard]] nlohmann::json json_of(const LocateResult& result, bool is_3d);

/// Of the speaker, seen from the camera: left and up are positive.
[[nodiscard]] double azimuth_deg(const Vector3& position_m);
[[nodiscard]] double elevation_deg(const Vector3& position_m);

}  // namespace earpoint
