#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/generate/generation.h>
#include <earpoint/generate/scene_maker.h>

namespace earpoint {

/// The options of `earpoint simulate`, as they are given.
struct SimulateOptions {
  GenerationOptions generation;
  std::vector<std::filesystem::path> scenes;  ///< scans or models instead of homes
  std::optional<std::filesystem::path> materials;
  std::optional<std::filesystem::path> speech;  ///< nothing: what ./dev speech gathers
  std::string up_axis;                          ///< "y", "z" or empty
  double unit_m = 1.0;
  std::string split;
  std::string shard;  ///< "i/n" or empty
  int jobs = 0;       ///< 0: all cores
  bool close_ceiling = false;
  bool released_speech = false;
};

/// Simulates a data set.
/// @param warn  takes what the importer of `scenes` warns of; called from many threads
/// @throws InputError naming the flag that is out of range, and as generate_dataset()
[[nodiscard]] GenerationSummary simulate(SimulateOptions options, const FileSceneMaker::Warn& warn,
                                         ProgressSink& progress);

}  // namespace earpoint
