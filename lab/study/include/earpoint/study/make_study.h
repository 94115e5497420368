#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <span>
#include <string>

#include <earpoint/core/progress.h>
#include <earpoint/evaluate/method.h>
#include <earpoint/study/study.h>
#include <earpoint/study/study_material.h>

namespace earpoint {

/// How a study is made.
struct StudyRequest {
  StudyDesign design = StudyDesign::choice;
  std::string title;
  std::string data;   ///< name of the data set
  std::string split;  ///< of the material
  std::size_t count = 20;
  std::size_t controls = 2;  ///< clips that ask for the reference itself; of the design choice
  std::uint64_t seed = 1;
  double duration_s = 3.0;  ///< of the material's samples
  bool match_loudness = true;
  std::set<std::string> baselines;
  int jobs = 1;  ///< threads
};

/// Loudness of every reference, LKFS, unless a sound of its clip would exceed full scale.
inline constexpr double kStudyLoudnessLkfs = -26.0;

/// Draws clips, asks every method about them and writes a folder that is the whole study. The seed
/// decides which clips: every one from another conversation, and conversations from as many scenes
/// as there are. Sounds begin and end with fades of 10 ms. With matched loudness every sound of a
/// clip is as loud as its reference, by loudness_lkfs(); in any case all of a clip get one common
/// gain, to the same loudness as other clips.
///
/// The same request on the same machine gives the same bytes.
/// @param methods  two or more, no oracles; of the design choice three at least are the paper's
/// @param folder   must not be there, or be empty
/// @throws InputError if the folder is in use, a method is named like a condition, the material
///         lacks pairs, or as Method::render
Study make_study(const StudyMaterial& material, std::span<const MethodEntry> methods,
                 const StudyRequest& request, const std::filesystem::path& folder,
                 ProgressSink& progress);

}  // namespace earpoint
