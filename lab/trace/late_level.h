#pragma once

#include <array>
#include <complex>
#include <span>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/core/octave_bands.h>
#include <earpoint/spatial/octave_bands.h>

namespace earpoint {

/// What a band of the octave bank passes of noise whose bands are shaped apart: white noise of
/// power 1, split by the bank, each band under its own gain, joined and sent through band `b`
/// again, has the power sum_ij gain_i gain_j share(b, i, j).
class BandOverlap {
 public:
  explicit BandOverlap(const OctaveBank& bank);

  /// @param powers  of the bands before they are joined
  /// @return        what each band then holds
  [[nodiscard]] BandArray through(const BandArray& powers) const;

 private:
  BandArray own_{};        // [b]: gain_b gain_b
  BandArray above_{};      // [b]: gain_b gain_{b+1}, seen from b
  BandArray below_{};      // [b]: gain_b gain_{b-1}, seen from b
  BandArray far_above_{};  // [b]: gain_{b+1} gain_{b+1}, seen from b
  BandArray far_below_{};  // [b]: gain_{b-1} gain_{b-1}, seen from b
};

/// Brings the energy of shaped noise to what it should be. Noise that is shaped by an envelope has
/// the right energy on average over many draws; one draw of it fluctuates, in a low band by several
/// dB over the few periods of a decay. This takes out the slow part of the fluctuation: stretch by
/// stretch of about 4 dB of the band's decay, and not shorter than the band can resolve.
/// @param expected   power per band over time, points `hop_samples` apart; of all channels together
/// @param channels   the noise; all get the same gain, so that their differences stay
void level_noise(std::span<const BandArray> expected, double hop_samples, const OctaveBank& bank,
                 int sample_rate_hz, RealFft<float>& fft, std::span<std::vector<float>> channels);

}  // namespace earpoint
