#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/evaluate/clip_metrics.h>
#include <earpoint/evaluate/earpoint_clip.h>
#include <earpoint/evaluate/view_figure.h>
#include <earpoint/locate/people_detector.h>

namespace earpoint {

/// A way to render the clip: what `earpoint render --model` takes.
struct ClipMethod {
  std::string name;   ///< of its column: "input", "dsp", "gtf", ...
  std::string model;  ///< `input`, `dsp`, or the path of a weight file
};

/// Levels of a binaural sound.
struct EarLevels {
  double level_db = 0.0;       ///< of both ears together, relative to the clip as it was recorded
  double left_right_db = 0.0;  ///< level of the left ear less that of the right
};

/// What a method made of one earpoint.
struct RenderedEarpoint {
  std::filesystem::path sound;
  EarLevels levels;
  ClipMetrics metrics;  ///< at 16 kHz, over the whole clip; clarity and early decay are not known
};

struct EarpointResult {
  EarLevels truth;
  std::vector<RenderedEarpoint> renderings;  ///< by method
};

struct EarpointComparison {
  EarpointClip clip;
  std::vector<ClipMethod> methods;
  std::vector<EarpointResult> earpoints;  ///< as the clip lists them
  std::filesystem::path source;           ///< the clip's sound
};

struct ComparisonOptions {
  ReverberationEstimator estimator{};  ///< for rte; empty: none
  int threads = 1;
  /// Finds the speaker for gtf in the clip's picture, as for `earpoint render`; null: gtf gets
  /// nothing about the speaker.
  PeopleDetector* detector = nullptr;
};

/// Renders the clip for each earpoint by each method as `earpoint render` does and measures what
/// comes out against what was heard there. gtf gets who was found to speak, dsp the speaker's
/// position, other networks the box.
///
/// @param folder  gets the sounds: source.flac, and a file for each earpoint and method
/// @throws InputError as render(), as read_sound(); if a truth is not binaural or not as long as
///         the clip (20 ms more or less are cut off), or a method needs to know of the speaker what
///         the description does not have
[[nodiscard]] EarpointComparison compare_earpoints(const EarpointClip& clip,
                                                   std::span<const ClipMethod> methods,
                                                   const std::filesystem::path& folder,
                                                   const ComparisonOptions& options,
                                                   ProgressSink& progress);

/// One table for people, a line for each earpoint.
[[nodiscard]] std::string text_of(const EarpointComparison& comparison);

/// The JSON of `earpoint evaluate --earpoints --json`; docs/formats.md describes it.
[[nodiscard]] std::string json_of(const EarpointComparison& comparison);

/// Writes FOLDER/index.html, a page with players, the clip's picture, a map, and waveforms and
/// spectrograms of each earpoint, and FOLDER/overview.jpg with the most of it in one picture. The
/// page plays the files beside it.
/// @param folder  the one that compare_earpoints() has filled
void write_earpoint_page(const EarpointComparison& comparison, const std::filesystem::path& folder);

/// The comparison as a row of a figure: the clip, what every method made of each earpoint beside
/// the truth, and the enhanced speech at the right.
/// @param enhanced  a sound file of one channel; nothing: no such column
/// @throws InputError if a sound or picture cannot be read
[[nodiscard]] FigureRow figure_row(const EarpointComparison& comparison,
                                   const std::optional<std::filesystem::path>& enhanced);

}  // namespace earpoint
