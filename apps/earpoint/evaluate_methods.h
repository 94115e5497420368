#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/evaluate/method.h>

namespace earpoint {

/// What --methods and its companions ask for.
struct MethodRequest {
  /// Known names, NAME=WEIGHTS.safetensors, or names of shipped models.
  std::vector<std::string> words;
  std::filesystem::path data;  ///< where `tf` finds the training split
  std::string tf_index;        ///< locations, relative, or empty: by whether the scenes are known
  bool enhance = false;        ///< speech is asked for, not what a place hears
  DatasetLayout layout = DatasetLayout::soundspaces;
  bool recorded = false;      ///< the data tell no responses
  bool knows_speaker = true;  ///< the data tell where speakers are
  bool oracles = false;       ///< all of them as well, of recordings those that need no more
  /// `input` and every shipped model of the families gtf and vigas, or every run of `runs`,
  /// instead.
  bool ablations = false;
  /// Each of its folders that holds a best.safetensors is a row, named like the folder.
  std::optional<std::filesystem::path> runs;
};

/// The rows of the table.
/// @param scenes  of the pairs
/// @throws InputError if a method is not known, is named twice, or its file is bad
std::vector<MethodEntry> methods_of(const MethodRequest& request,
                                    const std::set<std::string>& scenes);

}  // namespace earpoint
