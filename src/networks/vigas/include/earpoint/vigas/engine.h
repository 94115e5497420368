#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <earpoint/core/resize.h>
#include <earpoint/image.h>
#include <earpoint/vigas/description.h>
#include <earpoint/vigas/weights.h>

namespace earpoint {

/// The numbers of one of a network's inputs, e.g. "tgt_pose".
struct ConditioningValues {
  std::string_view name;
  std::span<const float> values;
};

/// A ViGAS network, ready to run on the processor. What one clip needs is made in three steps, so
/// that clips with the same picture and windows with the same conditioning share the earlier ones:
///
///   picture -> image_feature() -> "visual_feat"
///   "visual_feat", "tgt_pose", "tgt_rotation", "bboxes" -> fuse() -> the fused vector
///   waveform at the source, fused vector -> synthesize() -> waveform at the target
///
/// Threads have no influence on the results. One caller at a time.
/// Source: Novel-View Acoustic Synthesis, CVPR 2023, section 5, and its released code.
class ViGas {
 public:
  /// Packs the weights, which are not needed afterwards.
  /// @param threads  > 0
  ViGas(const ViGasWeights& weights, int threads);
  ~ViGas();
  ViGas(ViGas&&) noexcept;
  ViGas& operator=(ViGas&&) noexcept;

  [[nodiscard]] const ViGasDescription& description() const;

  /// @param picture  RGB of any size; resized as the network was trained, without smoothing
  /// @return  `visual_feat`, [description().image_encoder->feature_width()]
  /// @throws std::logic_error if the network has no image encoder or the picture is not RGB
  [[nodiscard]] std::vector<float> image_feature(const Image& picture);

  /// @param picture  [3][height][width] of the encoder's size, 0 to 1
  [[nodiscard]] std::vector<float> image_feature(std::span<const float> picture);

  /// Joins the network's inputs and reduces them to the vector that conditions the synthesis.
  /// Allocates nothing.
  /// @param inputs  every one of description().inputs once, in any order, each of its width;
  ///                others are an error
  /// @param fused   [description().conditioning_width]
  void fuse(std::span<const ConditioningValues> inputs, std::span<float> fused);

  /// The sound at the target. Allocates nothing, unless the length is another than the last time.
  /// @param source  planar, [description().audio_channels][samples], left ear first, samples > 0,
  ///                at description().sample_rate_hz
  /// @param fused   [description().conditioning_width]
  /// @param output  planar, the size of `source`; must not overlap it
  void synthesize(std::span<const float> source, std::span<const float> fused,
                  std::span<float> output);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
