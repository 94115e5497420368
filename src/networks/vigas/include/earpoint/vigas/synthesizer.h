#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <earpoint/synthesis/synthesizer.h>
#include <earpoint/vigas/engine.h>
#include <earpoint/vigas/weights.h>

namespace earpoint {

/// Visually-guided acoustic synthesis: a network that looks and listens, window by window of the
/// length that it was trained on, a quarter of which overlaps.
/// Source: Novel-View Acoustic Synthesis, CVPR 2023, section 5.
class ViGasSynthesizer : public AcousticSynthesizer {
 public:
  /// @param weights  a network with an image encoder or none, of two audio channels, whose inputs
  ///                 are among visual_feat, tgt_pose, tgt_rotation and bboxes
  /// @param where    names the weights in messages
  /// @throws InputError if the network asks for anything else
  ViGasSynthesizer(const ViGasWeights& weights, const std::string& where, int threads);

  [[nodiscard]] WindowShape window_shape(int source_rate_hz) const override;
  [[nodiscard]] double ambient_cutoff_hz() const override;
  [[nodiscard]] PictureUse picture_use() const override;
  [[nodiscard]] bool needs_speaker_track() const override;
  [[nodiscard]] std::vector<std::string> warnings(const RenderOutline& outline) const override;
  void observe(const Observation& observation) override;
  [[nodiscard]] Waveform synthesize(const Pose& source_from_target) override;

 private:
  ViGas network_;
  Waveform sound_;
  std::shared_ptr<const Image> seen_;  ///< the picture of visual_feature_
  std::vector<float> visual_feature_;
  std::vector<float> box_;
  Pose world_from_source_;
  std::vector<float> fused_;
};

}  // namespace earpoint
