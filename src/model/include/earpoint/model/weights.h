#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/model/checkpoint.h>
#include <earpoint/model/network.h>
#include <earpoint/model/safetensors.h>
#include <earpoint/model/tensor.h>

namespace earpoint {

/// Key in a weight file's metadata: the network's description as JSON.
inline constexpr std::string_view kDescriptionKey = "earpoint.network";

enum class NetworkKind { vigas, gtf, rt60_estimator, vam, people };

/// What a weight file is of, by its description.
/// @param where  the file, for messages
/// @throws InputError if the file has no description or one of an unknown network
[[nodiscard]] NetworkKind network_kind(const SafetensorsFile& file, std::string_view where);

/// A ViGAS network whose every tensor was checked.
struct ViGasWeights {
  ViGasDescription description;
  /// Exactly those that required_tensors(description) names, float32, all finite.
  std::map<std::string, Tensor> tensors;
  /// Names of tensors that the file has and inference does not read, e.g. other output heads.
  std::vector<std::string> unused;

  /// @throws std::logic_error if no required tensor has that name
  [[nodiscard]] const Tensor& at(const std::string& name) const;
};

/// Takes the network out of a weight file; F16, BF16 and F64 tensors become float32.
/// @param where  the file, for messages
/// @throws InputError if the description is wrong, or a tensor is missing, has another shape than
///         the description asks for, is not of floating point or holds NaN or infinity
[[nodiscard]] ViGasWeights vigas_weights(SafetensorsFile file, std::string_view where);
[[nodiscard]] ViGasWeights read_vigas_weights(const std::filesystem::path& path);

/// A weight file that vigas_weights() reads back. `metadata` is written beside the description.
[[nodiscard]] SafetensorsFile vigas_weight_file(const ViGasWeights& weights,
                                                std::map<std::string, std::string> metadata = {});

/// An estimator of reverberation time whose every tensor was checked.
struct Rt60EstimatorWeights {
  Rt60Description description;
  /// Exactly those that required_tensors(description) names, float32, all finite.
  std::map<std::string, Tensor> tensors;
  std::vector<std::string> unused;

  /// @throws std::logic_error if no required tensor has that name
  [[nodiscard]] const Tensor& at(const std::string& name) const;
};

/// As vigas_weights().
[[nodiscard]] Rt60EstimatorWeights rt60_estimator_weights(SafetensorsFile file,
                                                          std::string_view where);
[[nodiscard]] Rt60EstimatorWeights read_rt60_estimator_weights(const std::filesystem::path& path);

/// A weight file that rt60_estimator_weights() reads back. `metadata` is written beside the
/// description.
[[nodiscard]] SafetensorsFile rt60_weight_file(const Rt60EstimatorWeights& weights,
                                               std::map<std::string, std::string> metadata = {});

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
