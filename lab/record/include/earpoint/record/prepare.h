#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/record/session.h>

namespace earpoint {

struct PrepareOptions {
  std::filesystem::path out;         ///< of the data set, which may hold other scenes
  std::optional<std::string> split;  ///< train, val or test; nothing: as the session says, or that
                                     ///< of the published lists, or train
  double hop_s = 0.5;                ///< between the beginnings of windows
};

struct PrepareSummary {
  std::string scene;
  std::string split;
  int cameras = 0;
  int windows = 0;
  int silent = 0;       ///< left out, as nobody speaks
  int noisy = 0;        ///< left out for a knock or a clap
  int clips = 0;        ///< that the scene has now
  int made = 0;         ///< of them, by this call
  int overlapping = 0;  ///< of them, in which a second person speaks
  std::vector<std::string> notes;
};

/// Turns a session into clips of one second in the layout of Replay-NVAS v3, beside those of other
/// sessions: docs/formats.md, "Prepared sessions". A call that was killed goes on where it was; one
/// that finds everything there makes nothing.
/// @throws InputError if fewer than two cameras are calibrated and synchronised, no near microphone
///         can be used, no window holds speech, or the folder holds the scene of another session
[[nodiscard]] PrepareSummary prepare_session(const Session& session, const PrepareOptions& options,
                                             ProgressSink& progress);

}  // namespace earpoint
