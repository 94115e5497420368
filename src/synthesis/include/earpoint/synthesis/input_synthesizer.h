#pragma once

#include <earpoint/synthesis/synthesizer.h>

namespace earpoint {

/// The paper's first baseline: the target hears what the source heard. Takes the recording's rate.
class InputSynthesizer : public AcousticSynthesizer {
 public:
  [[nodiscard]] WindowShape window_shape(int source_rate_hz) const override;
  void observe(const Observation& observation) override;
  [[nodiscard]] Waveform synthesize(const Pose& source_from_target) override;

 private:
  Waveform sound_;
};

}  // namespace earpoint
