#pragma once

#include <memory>
#include <string>
#include <vector>

#include <earpoint/synthesis/synthesizer.h>
#include <earpoint/vam/engine.h>
#include <earpoint/vam/weights.h>

namespace earpoint {

/// Visual acoustic matching as a baseline: the picture of the source view and the target's pose,
/// without a speaker's box; windows as ViGasSynthesizer has them.
/// Source: Novel-View Acoustic Synthesis, CVPR 2023, section 6.
class VamSynthesizer : public AcousticSynthesizer {
 public:
  /// @param where  names the weights in messages
  /// @throws InputError if the network is not binaural
  VamSynthesizer(VamWeights weights, const std::string& where, int threads);

  [[nodiscard]] WindowShape window_shape(int source_rate_hz) const override;
  [[nodiscard]] double ambient_cutoff_hz() const override;
  [[nodiscard]] PictureUse picture_use() const override { return PictureUse::always; }
  void observe(const Observation& observation) override;
  [[nodiscard]] Waveform synthesize(const Pose& source_from_target) override;

 private:
  Vam network_;
  Waveform sound_;
  std::shared_ptr<const Image> seen_;  ///< the picture of map_
  std::vector<float> map_;
};

}  // namespace earpoint
