#pragma once

#include "evaluate_methods.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <earpoint/core/progress.h>
#include <earpoint/evaluate/earpoint_comparison.h>

namespace earpoint {

/// What `earpoint evaluate --data --figure` is asked.
struct FigureRequest {
  std::filesystem::path output;
  MethodRequest methods;  ///< its data and layout are those of the clips
  std::string split = "test";
  std::vector<std::string> clips{};  ///< as ViewedClipChoice::names
  std::size_t count = 1;
};

/// @throws InputError if the file's name does not end in .svg or cannot be written
void check_figure_path(const std::filesystem::path& path);

/// Draws clips of a data set: source, targets as the methods render them, and the enhanced speech
/// where a model for that is shipped.
/// @throws InputError as read_viewed_clips() and methods_of()
void draw_figure(const FigureRequest& request, ProgressSink& progress);

/// The same of a clip whose earpoints were compared.
/// @param folder  for the enhanced sound, which is left there
void draw_figure(const std::filesystem::path& output, const EarpointComparison& comparison,
                 const std::filesystem::path& folder, int threads, ProgressSink& progress);

}  // namespace earpoint
