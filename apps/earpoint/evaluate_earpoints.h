#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/evaluate/clip_metrics.h>

namespace earpoint {

/// What `earpoint evaluate --earpoints` is asked.
struct EarpointsRequest {
  std::filesystem::path description;
  std::vector<std::string> methods;  ///< empty: input, dsp if the speaker is known, and gtf
  std::optional<std::filesystem::path> report;
  std::optional<std::filesystem::path> figure;
  ReverberationEstimator estimator;
  std::string detector;  ///< as --detector has it
  int threads = 1;
  bool json = false;
  bool quiet = false;
};

/// Renders a clip for the places where it is known what it sounded like, and prints how near the
/// methods come.
/// @throws InputError if a method or a file is bad
void evaluate_earpoints(const EarpointsRequest& request, ProgressSink& progress);

}  // namespace earpoint
