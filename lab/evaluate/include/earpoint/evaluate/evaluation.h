#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/dataset/speaker_boxes.h>
#include <earpoint/evaluate/clip_metrics.h>
#include <earpoint/evaluate/evaluation_set.h>
#include <earpoint/evaluate/method.h>

namespace earpoint {

/// What all methods made of one pair.
struct ClipResult {
  std::size_t pair = 0;  ///< in the evaluation set
  std::string name;
  std::string scene;
  int cluster = 0;
  std::optional<std::string> voice;  ///< nothing where the data do not tell
  Pose source_from_target;
  std::optional<Vector3> speaker_m;  ///< source view's frame; nothing where it is not known
  bool speaker_in_sight = false;     ///< of the source view
  /// SI-SDR of what the source heard against what it would hear without ambient sound, mean over
  /// the ears: of all it heard, and of the primary sound. Nothing where nothing was separated.
  std::optional<double> heard_si_sdr_db;
  std::optional<double> primary_si_sdr_db;
  std::vector<ClipMetrics> honest;    ///< by method
  std::vector<ClipMetrics> released;  ///< by method, with the released evaluation's oracles
};

/// A pair that could not be read.
struct BadPair {
  std::string name;
  std::string problem;  ///< one line: file, what is wrong, a hint
};

struct EvaluationResult {
  struct Row {
    std::string name;
    std::string what;
    bool is_oracle = false;
    /// Batches of the released evaluation whose sign fix negated an ear.
    std::size_t sign_fixes = 0;
  };
  std::vector<Row> methods;
  std::vector<ClipResult> clips;
  std::vector<BadPair> skipped;
};

struct EvaluationOptions {
  int jobs = 1;  ///< threads
  /// Leave out pairs that cannot be read, instead of stopping at the first.
  bool skip_bad = false;
  /// Measure SI-SDR and ESTOI too: targets are speech to be understood.
  bool judges_speech = false;
  /// Makes the estimator of a thread; empty: no RTE.
  std::function<ReverberationEstimator()> make_estimator;
  /// Makes what gives methods the speaker, for a thread; empty: the truth. Oracles always get
  /// the truth.
  std::function<SpeakerTelling()> make_telling{};
};

/// Pairs in one batch of the released evaluation, over which its sign fix decides.
inline constexpr std::size_t kReleasedBatch = 32;

/// Runs every method on every pair and measures it twice: honestly, and with what the released
/// evaluation does with the target (fix_sign over batches of the list's order, where
/// MethodEntry::fixes_sign, and EvaluationSet::released_sample). Only oracles are given the target
/// and the truth.
///
/// The number of threads has no influence on the result.
/// @throws InputError for a pair that cannot be read, unless skip_bad; for a method that lacks what
///         it needs, naming it; and if no pair is left
[[nodiscard]] EvaluationResult evaluate(const EvaluationSet& set,
                                        std::span<const MethodEntry> methods,
                                        const EvaluationOptions& options, ProgressSink& progress);

}  // namespace earpoint
