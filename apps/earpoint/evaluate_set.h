#pragma once

#include "evaluate_methods.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/audio/ambient_separation.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/evaluate/evaluation.h>

namespace earpoint {

/// What `earpoint evaluate` is asked for.
struct EvaluateOptions {
  std::filesystem::path data;
  std::filesystem::path earpoints;
  std::string split = "test";
  std::string layout;  ///< empty: whichever there is
  std::optional<std::filesystem::path> pairs;
  std::string draw;  ///< empty: the frozen list
  MethodRequest methods;
  std::optional<std::size_t> limit;
  int jobs = 0;
  std::filesystem::path rt60_model;
  std::optional<std::filesystem::path> report;
  std::optional<std::filesystem::path> figure;
  std::vector<std::string> clips;    ///< of the figure
  std::vector<std::string> ambient;  ///< level in dB, separation, or both
  double context_s = 0.0;
  std::string boxes = "true";
  std::optional<std::filesystem::path> detector;
  bool enhance = false;
  bool skip_bad = false;
  bool json = false;
  bool quiet = false;
};

/// Room noise in what sources hear, and how it is separated.
struct EvaluateAmbient {
  std::optional<double> level_db;  ///< re full scale; nothing: no noise
  AmbientSeparation separation = AmbientSeparation::bandpass;
};

/// @throws InputError if a word of --ambient is neither a level nor a separation
EvaluateAmbient ambient_of(const EvaluateOptions& options);

PairTarget target_of(const EvaluateOptions& options);
DatasetLayout layout_of(const EvaluateOptions& options);

/// The pairs that methods are compared on.
/// @throws InputError if the data set lacks something, or recordings are asked for what they do not
///         have
std::unique_ptr<EvaluationSet> evaluation_set(const EvaluateOptions& options);

}  // namespace earpoint
