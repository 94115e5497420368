#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <earpoint/evaluate/method.h>

/// What --methods and its companions ask for.
struct MethodRequest {
  /// Known names, NAME=WEIGHTS.safetensors, or names of shipped models.
  std::vector<std::string> words;
  std::filesystem::path data;  ///< where `tf` finds the training split
  std::string tf_index;        ///< locations, relative, or empty: by whether the scenes are known
  bool oracles = false;        ///< all of them as well
};

/// The rows of the table.
/// @param scenes  of the pairs
/// @throws earpoint::InputError if a method is not known, is named twice, or its file is bad
std::vector<earpoint::MethodEntry> methods_of(const MethodRequest& request,
                                              const std::set<std::string>& scenes);
