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
  std::string tf_index;        ///< "locations" or "relative"; empty: as transfer_index_for()
  bool enhance = false;        ///< the answer is the dry speech, not the sound at the target
  DatasetLayout layout = DatasetLayout::soundspaces;
  bool recorded = false;      ///< the data have no impulse responses
  bool knows_speaker = true;  ///< the data tell where speakers are
  bool oracles = false;  ///< adds all oracles; for recordings those that need no impulse responses
  /// In place of `words`: `input` and every run of `runs`, or without it every shipped model of the
  /// families gtf and vigas.
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
