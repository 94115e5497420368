#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <earpoint/weights/checkpoint.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// A checkpoint in the form that the released code saves and strictly loads.
struct ReleasedCheckpoint {
  /// Every entry of the network's state dict, in its order, with batch norms' counters, all output
  /// heads and the last layer's `residual`.
  std::vector<std::pair<std::string, Tensor>> state_dict;
  /// Every option that the released code reads, in the order of its command line.
  std::vector<std::pair<std::string, HyperParameter>> hparams;
  /// Names of tensors that the weight file lacks and inference does not read: they are zero.
  std::vector<std::string> filled;
  /// What the released class builds otherwise, e.g. "channels: 64 there, 32 here": without a change
  /// of the class such a checkpoint does not load. Empty for the published network.
  std::vector<std::string> differences;
};

/// Makes a checkpoint of a weight file of a ViGAS network. Options are those of the weight file
/// ("earpoint.hparams"), if it has any, over the published ones of its data set; those that its
/// description knows follow the description.
/// @param where  the file, for messages
/// @throws InputError as vigas_weights(); if the network is not a ViGAS; and if the released code
///         cannot say its poses and boxes: they must both be `soundspaces`, or `replay` and
///         `corners`
[[nodiscard]] ReleasedCheckpoint released_checkpoint(SafetensorsFile file, std::string_view where);

/// The file that torch.save would write: a zip archive with a pickle of protocol 2.
/// @param folder  the archive's folder: the file's name without extension
/// @throws InputError if it would be larger than 4 GB
[[nodiscard]] std::vector<std::byte> serialize_checkpoint(const ReleasedCheckpoint& checkpoint,
                                                          std::string_view folder);

}  // namespace earpoint
