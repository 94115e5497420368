#pragma once

#include <string>
#include <vector>

#include <earpoint/evaluate/method.h>

/// The rows that --methods names.
/// @param words  known names, NAME=WEIGHTS.safetensors, or names of shipped models
/// @throws earpoint::InputError if one is not known, is named twice, or its file is bad
std::vector<earpoint::MethodEntry> methods_of(const std::vector<std::string>& words);
