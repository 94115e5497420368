#pragma once

#include <filesystem>
#include <optional>

#include <earpoint/spatial/dsp_renderer.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/synthesis/synthesizer.h>

namespace earpoint {

/// The signal-processing baseline: the speaker's sound estimated by inverse head filters at the
/// source, then heard through the head filters and the distance of the target. It needs to know
/// where the speaker is: told as a point, or estimated from the box in the picture.
///
/// Takes the recording's rate; windows of 0.1 s overlap by half, so that a moving earpoint turns
/// smoothly. Source: Novel-View Acoustic Synthesis, CVPR 2023, section 6, baseline 3.
class DspSynthesizer : public AcousticSynthesizer {
 public:
  /// @param hrtf                a SOFA file; default: the KEMAR set
  /// @param horizontal_fov_rad  of the source camera, for the estimate from a box
  DspSynthesizer(std::optional<std::filesystem::path> hrtf, double horizontal_fov_rad);

  [[nodiscard]] WindowShape window_shape(int source_rate_hz) const override;
  [[nodiscard]] PictureUse picture_use() const override { return PictureUse::with_box; }
  void observe(const Observation& observation) override;
  [[nodiscard]] Waveform synthesize(const Pose& source_from_target) override;

 private:
  [[nodiscard]] Vector3 locate_speaker(const Observation& observation) const;
  const HrtfSet& hrtf(int sample_rate_hz) const;

  std::optional<std::filesystem::path> hrtf_path_;
  double horizontal_fov_rad_;
  mutable std::optional<HrtfSet> hrtf_;  // loaded once the recording's rate is known
  Waveform sound_;
  Vector3 speaker_m_;
};

}  // namespace earpoint
