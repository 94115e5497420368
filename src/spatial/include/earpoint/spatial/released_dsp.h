#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/spatial/sofa_file.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// The DSP baseline of the paper's tables exactly as its released code computes it, quirks
/// included: for comparing with published numbers and for nothing else. Use dsp_renderer.h to
/// render.
///
/// The quirks: azimuth and elevation are looked up one by one in whole degrees and do not wrap
/// round (353 finds 345 or 355, never 0); each filter adds one sample of delay; the inverse filter
/// is circular in the length of the response, so what rings beyond it folds back; the ears'
/// estimates of the source are averaged, however faint one is.
class ReleasedDsp {
 public:
  /// Angles as the set of filters lists them, in degrees; distance in metres.
  struct Position {
    double azimuth_deg = 0.0;
    double elevation_deg = 0.0;
    double distance_m = 0.0;
  };

  /// @param azimuth_elevation_deg  one pair per measurement; the fraction is dropped
  /// @param responses              [measurement][ear][taps]
  /// @throws std::logic_error if the sizes do not fit
  ReleasedDsp(std::span<const std::array<double, 2>> azimuth_elevation_deg,
              std::span<const float> responses, int taps);

  /// Azimuths in [0, 360). The sounds must have the file's sampling rate.
  explicit ReleasedDsp(const SofaFile& file);

  /// Both ears' sound of a source, with its distance gain.
  /// @param mono  shape [samples]
  /// @return  shape [2][samples + 1]; sample 0 is zero
  /// @throws InputError if there is no measurement at the looked-up pair of angles
  [[nodiscard]] Waveform apply(std::span<const float> mono, const Position& position,
                               int sample_rate_hz) const;

  /// The source's sound as estimated from both ears.
  /// @param binaural  shape [2][samples]
  /// @return  shape [samples + 1]; sample 0 is zero
  /// @throws InputError as apply
  [[nodiscard]] std::vector<float> apply_inverse(const Waveform& binaural,
                                                 const Position& position) const;

  /// The distance gain 0.2 / max(0.2, distance).
  [[nodiscard]] static double gain(double distance_m);

 private:
  [[nodiscard]] std::size_t measurement(const Position& position) const;
  [[nodiscard]] std::span<const float> response(std::size_t measurement, int ear) const;

  std::vector<std::array<int, 2>> positions_deg_;
  std::vector<float> responses_;
  int taps_;
};

}  // namespace earpoint
