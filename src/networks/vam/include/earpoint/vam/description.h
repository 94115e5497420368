#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace earpoint {

/// Visual acoustic matching, as a baseline for a new viewpoint: strided convolutions make tokens of
/// the sound, a ResNet-18 makes tokens of the picture, the target's pose joins both, blocks of
/// attention and convolution let the sound look at the picture, and transposed convolutions with
/// shortcuts from the encoder make sound again. docs/formats.md has the layers.
/// Source: Chen et al., Visual Acoustic Matching (CVPR 2022), as adapted in Novel-View Acoustic
/// Synthesis (CVPR 2023), section 6; docs/formats.md says what differs.
struct VamDescription {
  int sample_rate_hz = 16000;
  int window_samples = 16000;                ///< length of the clips that it was trained on
  std::optional<double> highpass_cutoff_hz;  ///< its training sounds have nothing below
  int hop_samples = 160;                     ///< of the STFT in its training loss
  int audio_channels = 2;                    ///< the ears

  int image_width_px = 256;
  int image_height_px = 256;
  int trunk_channels = 64;  ///< of the ResNet-18's first stage

  std::vector<int> strides{5, 4, 4, 2};         ///< of the encoder's levels, outermost first
  std::vector<int> channels{32, 64, 128, 192};  ///< of each level; the last is the tokens' width
  int blocks = 2;
  int heads = 4;
  int feed_forward_width = 576;
  int kernel_size = 15;  ///< taps over the tokens, odd

  /// Of what is said about the target: PoseEncoding::full, position and turn.
  static constexpr int kPoseWidth = 9;

  [[nodiscard]] int levels() const { return static_cast<int>(strides.size()); }
  /// Numbers in a token.
  [[nodiscard]] int width() const { return channels.back(); }
  /// Samples that one token stands for.
  [[nodiscard]] int token_samples() const;
  /// Tokens of the picture: one for every place of the ResNet's map.
  [[nodiscard]] int image_tokens() const;
  /// Numbers in a place of the ResNet's map.
  [[nodiscard]] int map_channels() const { return 8 * trunk_channels; }
  /// Taps of a level's (transposed) convolution: as many samples as its stride, and half as many on
  /// either side.
  [[nodiscard]] int taps(int level) const { return strides[level] + 2 * padding(level); }
  [[nodiscard]] int padding(int level) const { return strides[level] / 2; }
  /// Channels that a level's convolution reads, and that its transposed convolution gives.
  [[nodiscard]] int encoder_inputs(int level) const;
  [[nodiscard]] int decoder_outputs(int level) const;
};

/// @throws InputError naming the field, what was expected and what was found
void check_description(const VamDescription& description, std::string_view where);
[[nodiscard]] std::string to_json(const VamDescription& description);
/// Unknown, missing and repeated keys are errors. @throws InputError
[[nodiscard]] VamDescription vam_description_from_json(std::string_view json,
                                                       std::string_view where);

/// Name and shape of every tensor; all are float32.
[[nodiscard]] std::map<std::string, std::vector<std::int64_t>> required_tensors(
    const VamDescription& description);

}  // namespace earpoint
