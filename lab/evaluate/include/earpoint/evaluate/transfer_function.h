#pragma once

#include <filesystem>
#include <set>
#include <string>

#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/evaluate/method.h>

namespace earpoint {

/// What makes a pair of viewpoints near another.
enum class TransferIndex {
  /// Where speaker, source and target are in the scene and where they look: for scenes that were
  /// trained on.
  locations,
  /// Where speaker and target are as the source sees them, and where they look: for any scene.
  relative_pose,
};

/// @return locations if every one of the scenes is in the training split, else relative_pose
/// @throws InputError if the data set has no training split
[[nodiscard]] TransferIndex transfer_index_for(const std::filesystem::path& folder,
                                               DatasetLayout layout,
                                               const std::set<std::string>& scenes);

/// The paper's "TF Estimator + Nearest Neighbor": of all pairs of the training split the nearest to
/// the question is looked up by true positions; between its source and its target a Wiener filter
/// per ear is estimated from one second of their sounds (filter_fit.h), and that filter is applied.
/// The paper computes all filters beforehand; here only those that are asked for.
///
/// Nearest by the sum of squared distances of the positions in metres, a turn of t radians counting
/// as 2 sin(t / 2) metres.
/// Source: Novel-View Acoustic Synthesis, CVPR 2023, section 6, baseline 2.
/// @param folder  of the data set; its split `train` is read
/// @throws InputError if there is none, or it has no positions of speakers, as the published
///         Replay-NVAS
[[nodiscard]] MethodEntry transfer_function_method(const std::filesystem::path& folder,
                                                   DatasetLayout layout, TransferIndex index);

}  // namespace earpoint
