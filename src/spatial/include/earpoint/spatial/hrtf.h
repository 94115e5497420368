#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/spatial/sofa_file.h>
#include <earpoint/vector3.h>

namespace earpoint {

/// Head-related impulse responses of both ears for one direction; ear 0 is the left one.
struct Hrir {
  std::array<std::vector<float>, 2> taps;  ///< [ear][taps], the ear's own delay included
  std::array<double, 2> onset_samples{};   ///< when the sound reaches each ear, in the taps' time
};

/// What is done to the measured responses at load.
enum class HrtfEqualization {
  none,
  /// One minimum-phase filter for all directions divides by the set's power average over the
  /// sphere (third-octave smoothed, up to 18 dB either way). It takes away the loudspeaker and
  /// the ear canal, and puts the set's level right: in a diffuse field an ear then picks up what
  /// an omnidirectional microphone would. Adds 11.6 ms to the responses' length.
  diffuse_field
};

/// A set of head-related impulse responses at one sampling rate, with lookup by direction.
/// Directions are vectors in the listener's frame (x front, y left, z up) of any length but zero.
/// Immutable: cheap to copy, safe from several threads.
///
/// Between measurements an ear's onset time, log magnitude and phase without the onset are each
/// interpolated over the triangle of measured directions around the wanted one, and the onset is
/// put back as a fractional delay (a phase ramp: no error below Nyquist). So there is no comb
/// filter between neighbours, and ITD and spectrum change smoothly. Where nothing was measured
/// within 20 degrees of straight up or down, the average of the nearest ring stands in for that
/// pole.
class HrtfSet {
 public:
  /// Uses the farthest sources of the file (within 10 % of the largest distance).
  /// @param sample_rate_hz  8000 or more; the responses are resampled to it, delay and gain kept
  /// @throws InputError if fewer than three directions are left or they do not surround the head
  HrtfSet(const SofaFile& file, int sample_rate_hz,
          HrtfEqualization equalization = HrtfEqualization::diffuse_field);

  /// Reads a SOFA file. @throws InputError as read_sofa, default_hrtf_path and the constructor
  static HrtfSet load(int sample_rate_hz);
  static HrtfSet load(const std::filesystem::path& path, int sample_rate_hz,
                      HrtfEqualization equalization = HrtfEqualization::diffuse_field);

  [[nodiscard]] int sample_rate_hz() const;
  /// Length of every response.
  [[nodiscard]] int taps() const;
  /// Number of measured directions.
  [[nodiscard]] std::size_t size() const;
  /// Unit vector to where the source of a measurement stood.
  [[nodiscard]] const Vector3& direction(std::size_t measurement) const;
  /// One measured response, shape [taps].
  [[nodiscard]] std::span<const float> response(std::size_t measurement, int ear) const;
  /// When the sound reaches the ear, in samples from the response's start: where the response
  /// first exceeds a tenth of its peak, between samples.
  [[nodiscard]] double onset_samples(std::size_t measurement, int ear) const;

  /// How far from the middle of the head the sources stood, metres.
  [[nodiscard]] double distance_m() const;

  /// When the sound would pass the middle of the head were it not there, in samples from the
  /// start of every response: take it off to place an arrival at its travel time.
  [[nodiscard]] double centre_delay_samples() const;

  /// The measurement nearest by angle. Allocates nothing.
  [[nodiscard]] std::size_t nearest(const Vector3& direction) const;
  [[nodiscard]] Hrir measured(std::size_t measurement) const;

  /// The response between the measurements; at a measured direction that measurement itself, to
  /// -60 dB of its energy. Cost: 0.05 to 0.2 ms. Allocates, so not for the audio thread.
  [[nodiscard]] Hrir interpolated(const Vector3& direction) const;

  /// The same for a source at a distance from the head's middle, in free field level at the middle
  /// as before. Nearer than the set was measured, the ears' levels and delays change as at a rigid
  /// sphere (`near_field_spectra`): at 0.3 m and 90 degrees the level between the ears is 6 dB more
  /// than at 1.4 m. Farther away it is the measured response. Cost: 0.2 to 1 ms when near.
  /// @param distance_m  > 0
  [[nodiscard]] Hrir interpolated(const Vector3& direction, double distance_m) const;

 private:
  friend class HrirInterpolator;
  struct State;
  std::shared_ptr<const State> state_;
};

/// HrtfSet::interpolated() again and again without allocating, for the audio thread. An object
/// holds its own work space: use one per thread.
class HrirInterpolator {
 public:
  explicit HrirInterpolator(HrtfSet set);

  /// @param direction   not zero
  /// @param distance_m  > 0
  /// @param hrir        gets the response; allocates only if its taps are not set.taps() long yet
  void interpolate(const Vector3& direction, double distance_m, Hrir& hrir);

 private:
  void near_field(const Vector3& direction, double distance_m);

  HrtfSet set_;
  RealFft<float> fft_;
  std::vector<std::complex<float>> spectrum_;
  std::vector<float> padded_;
  std::array<std::vector<std::complex<float>>, 2> near_spectra_;  ///< [ear][bins]
  std::array<double, 2> near_later_samples_{};
};

}  // namespace earpoint
