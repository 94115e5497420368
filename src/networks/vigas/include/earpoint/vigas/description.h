#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/network/pose_encoding.h>
#include <earpoint/weights/checkpoint.h>

namespace earpoint {

/// One of the inputs that are joined into the conditioning vector.
struct ConditioningInput {
  std::string name;  ///< "visual_feat", "tgt_pose", ...
  int width = 0;     ///< numbers per clip
};

/// The trunk that makes `visual_feat` of the picture: a ResNet-18 without pooling and classifier,
/// then a 1x1 convolution to `channels`, flattened [channel][row][column].
struct ImageEncoderDescription {
  int width_px = 0;
  int height_px = 0;
  int channels = 0;
  int trunk_channels = 64;  ///< of the ResNet-18's first stage

  /// Of the ResNet-18's map, which the 1x1 convolution reads.
  [[nodiscard]] int map_channels() const { return 8 * trunk_channels; }

  /// Width of `visual_feat`: channels * ceil(height / 32) * ceil(width / 32).
  [[nodiscard]] int feature_width() const;
};

/// A ViGAS network: everything that its weights alone do not say, and the dimensions that they do.
/// Source: docs/released-code.md; Novel-View Acoustic Synthesis, CVPR 2023, section 5.
struct ViGasDescription {
  PoseEncoding pose_encoding = PoseEncoding::soundspaces;
  BoxEncoding box_encoding = BoxEncoding::soundspaces;

  int sample_rate_hz = 16000;
  int window_samples = 16000;                ///< length of the clips that it was trained on
  std::optional<double> highpass_cutoff_hz;  ///< its training sounds have nothing below
  int hop_samples = 160;                     ///< of the STFT in its training loss

  /// Without one, `visual_feat` is an input like the others.
  std::optional<ImageEncoderDescription> image_encoder;

  std::vector<ConditioningInput> inputs;  ///< in the order of concatenation
  int fusion_width = 512;                 ///< hidden layer between the inputs and z
  int conditioning_width = 256;           ///< of z

  int audio_channels = 2;
  int channels = 64;  ///< of the gated stack
  int blocks = 3;
  int layers_per_block = 10;
  int kernel_size = 3;    ///< taps of the dilated convolutions
  int dilation_base = 3;  ///< layer i of a block has dilation base^i
  bool acausal = true;    ///< taps on both sides of the output sample, else only before it

  /// Of the gated stack: blocks * layers_per_block.
  [[nodiscard]] int layers() const;

  /// Samples between two taps of that layer, counted through all blocks.
  [[nodiscard]] int dilation(int layer) const;

  /// Width of all inputs together.
  [[nodiscard]] int input_width() const;

  /// Whether that input is among `inputs`.
  [[nodiscard]] bool has_input(std::string_view name) const;
};

/// Checks that a description is of a network that can exist: ranges, names and order of inputs,
/// widths against encodings.
/// @param where  the file, for messages
/// @throws InputError naming the field, what was expected and what was found
void check_description(const ViGasDescription& description, std::string_view where);

/// The description as JSON, one line, keys sorted. docs/formats.md has the schema.
[[nodiscard]] std::string to_json(const ViGasDescription& description);

/// The inverse of to_json, checked. Unknown, missing and repeated keys are errors.
/// @param where  the file, for messages
/// @throws InputError naming the field, what was expected and what was found
[[nodiscard]] ViGasDescription vigas_description_from_json(std::string_view json,
                                                           std::string_view where);

/// Name and shape of every tensor that inference reads; all are float32. The names are those of
/// the released code's state dict. The other output heads and the last layer's `residual` are not
/// among them: they have no effect on the output.
[[nodiscard]] std::map<std::string, std::vector<std::int64_t>> required_tensors(
    const ViGasDescription& description);

/// Describes the network in a checkpoint of the released code: dimensions come from the tensors,
/// the rest from the hyper-parameters.
/// @param where  the file, for messages
/// @throws InputError if a tensor or hyper-parameter is missing, or the network is of a kind that
///         is not supported (e.g. with depth images)
[[nodiscard]] ViGasDescription describe_vigas(const Checkpoint& checkpoint, std::string_view where);

}  // namespace earpoint
