#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <earpoint/gtf/engine.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/synthesis/synthesizer.h>

namespace earpoint {

/// What a gtf network is asked for.
struct GtfUse {
  /// 0 the mean, 1 natural; means nothing to a network with one texture.
  double texture = 1.0;
  /// Keep the level within what the geometry allows. Not of a network that was trained for
  /// enhancement: it is only kept from being louder than the recording by more than 12 dB.
  bool limits_level = true;
};

/// Geometric time-frequency synthesis, window by window, a quarter of which overlaps; a target that
/// moves is followed hop by hop within. A speaker who is known neither by place nor by box is
/// looked for by picture and sound.
class GtfSynthesizer : public AcousticSynthesizer {
 public:
  /// @param horizontal_fov_rad  of the source camera
  GtfSynthesizer(std::shared_ptr<const GtfWeights> weights, double horizontal_fov_rad,
                 const GtfUse& use = {});
  GtfSynthesizer(GtfWeights weights, double horizontal_fov_rad, const GtfUse& use = {});

  [[nodiscard]] WindowShape window_shape(int source_rate_hz) const override;
  [[nodiscard]] double ambient_cutoff_hz() const override;
  [[nodiscard]] PictureUse picture_use() const override;
  [[nodiscard]] std::vector<std::string> warnings(const RenderOutline& outline) const override;
  [[nodiscard]] std::unique_ptr<AcousticSynthesizer> twin() const override;
  void observe(const Observation& observation) override;
  [[nodiscard]] Waveform synthesize(const Pose& source_from_target) override;
  [[nodiscard]] Waveform synthesize_along(std::span<const Pose> path) override;

 private:
  struct View {
    std::shared_ptr<const Image> picture;
    std::optional<Box> speaker_box;

    friend bool operator==(const View&, const View&) = default;
  };

  std::shared_ptr<const GtfWeights> weights_;
  double horizontal_fov_rad_;
  GtfUse use_;
  Gtf network_;
  std::optional<View> seen_;  ///< what the network looked at last
  Waveform sound_;
  std::optional<Vector3> speaker_m_;
};

}  // namespace earpoint
