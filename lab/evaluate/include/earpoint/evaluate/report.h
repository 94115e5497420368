#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include <earpoint/core/progress.h>
#include <earpoint/evaluate/evaluation.h>
#include <earpoint/evaluate/evaluation_set.h>
#include <earpoint/evaluate/evaluation_table.h>

namespace earpoint {

struct ReportOptions {
  std::string data;  ///< what the page calls the data
  std::string split;
  std::string pairs;       ///< where they come from
  int random_clips = 3;    ///< shown besides the best, the median and the worst
  std::uint64_t seed = 1;  ///< that they are drawn with
};

/// Writes FOLDER/index.html: one page that holds everything it shows and needs no network. The
/// tables; error over distance and angle, with intervals; and clips to look at and listen to: the
/// source's picture with the speaker's box, a map, waveforms and spectrograms of both ears, and
/// players. Best, median and worst are by the Mag of the last method that is neither `input` nor an
/// oracle (of `input`, if there is no other).
/// @param set, methods  those of the evaluation: chosen clips are rendered again
/// @throws InputError if the folder cannot be made or written
void write_report(const std::filesystem::path& folder, const EvaluationSet& set,
                  std::span<const MethodEntry> methods, const EvaluationResult& result,
                  const ReportOptions& options, ProgressSink& progress);

}  // namespace earpoint
