#pragma once

#include <earpoint/infer/gtf.h>
#include <earpoint/model/gtf.h>
#include <earpoint/synth/synthesizer.h>

namespace earpoint {

/// Geometric time-frequency synthesis, window by window, a quarter of which overlaps; a target that
/// moves is followed hop by hop within. A speaker who is known neither by place nor by box is
/// looked for by picture and sound.
class GtfSynthesizer : public AcousticSynthesizer {
 public:
  /// @param horizontal_fov_rad  of the source camera
  /// @param texture  0 the mean, 1 natural; means nothing to a network that knows one
  GtfSynthesizer(const GtfWeights& weights, double horizontal_fov_rad, double texture = 1.0);

  [[nodiscard]] WindowShape window_shape(int source_rate_hz) const override;
  [[nodiscard]] double ambient_cutoff_hz() const override;
  [[nodiscard]] PictureUse picture_use() const override;
  [[nodiscard]] std::vector<std::string> doubts(const RenderOutline& outline) const override;
  void observe(const Observation& observation) override;
  [[nodiscard]] Waveform synthesize(const Pose& source_from_target) override;
  [[nodiscard]] Waveform synthesize_along(std::span<const Pose> path) override;

 private:
  struct View {
    std::shared_ptr<const Image> picture;
    std::optional<Box> speaker_box;

    friend bool operator==(const View&, const View&) = default;
  };

  Gtf network_;
  double horizontal_fov_rad_;
  std::optional<View> seen_;  ///< what the network looked at last
  Waveform sound_;
  std::optional<Vector3> speaker_m_;
};

}  // namespace earpoint
