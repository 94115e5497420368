#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include <earpoint/network/weights.h>
#include <earpoint/vigas/description.h>
#include <earpoint/weights/checkpoint.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// A ViGAS network, every tensor checked.
using ViGasWeights = NetworkWeights<ViGasDescription>;

/// @throws InputError as checked_weights()
[[nodiscard]] ViGasWeights vigas_weights(SafetensorsFile file, std::string_view where);
[[nodiscard]] ViGasWeights read_vigas_weights(const std::filesystem::path& path);

/// Which tensors of a checkpoint go into a weight file.
enum class KeepTensors {
  required,  ///< those that inference reads
  all,
};

/// Makes a weight file of a checkpoint of the released code: a ViGAS network, or the RT60
/// estimator (told by its tensor `feature_extraction.0.weight`). Its metadata also name the tensors
/// that were left out ("earpoint.dropped_tensors") and hold the options of the training run as
/// JSON ("earpoint.hparams").
/// @param where  the checkpoint's file, for messages
/// @throws InputError as vigas_weights() and describe_vigas()
[[nodiscard]] SafetensorsFile weight_file_from_checkpoint(Checkpoint checkpoint, KeepTensors keep,
                                                          std::string_view where);

}  // namespace earpoint
