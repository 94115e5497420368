#pragma once

#include "late_level.h"
#include "late_noise.h"
#include "pulse_train.h"

#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/spatial/octave_bands.h>
#include <earpoint/trace/tracer.h>

namespace earpoint {

/// The sizes that all parts of a rendered response share.
struct ResponseShape {
  int sample_rate_hz = 0;
  int samples = 0;
  int fft_size = 0;  ///< room for the bank's ringing on both sides
};

/// The noise of the energy histogram, and arrivals as microphones hear them.
class LateField {
 public:
  LateField(const ResponseShape& shape, std::uint64_t seed);

  /// The bank of octave bands, of the shape's size.
  [[nodiscard]] const OctaveBank& bank() const { return bank_; }

  /// Adds the sound at an omnidirectional microphone.
  /// @param arrivals  pulses at their exact times
  /// @param signal    shape [samples]
  void add_mono(const EnergyHistogram& late, std::span<const Arrival> arrivals,
                std::uint64_t stream, std::span<float> signal) const;

  /// Adds the noise at two ears: each sector's through the HRTF of its middle.
  /// @param ears  [ear][samples]
  void add_binaural(const EnergyHistogram& late, const Quaternion& world_from_listener,
                    const HrtfSet& hrtf, std::uint64_t stream,
                    std::span<std::vector<float>> ears) const;

  /// Adds the sound at an ambisonic microphone.
  /// @param channels  [ambisonic_channels(order)][samples]
  void add_ambisonic(const EnergyHistogram& late, std::span<const Arrival> arrivals,
                     const Quaternion& world_from_listener, int order, std::uint64_t stream,
                     std::span<std::vector<float>> channels) const;

 private:
  using SectorOffsets = std::array<std::ptrdiff_t, kSectors>;  // into the noise pool
  [[nodiscard]] SectorOffsets sector_offsets(std::uint64_t stream) const;
  void add_pulses(std::span<const Arrival> arrivals, std::span<const float> gains,
                  RealFft<float>& fft, PulseTrain& train, std::span<float> signal) const;
  void add_noise(const EnergyHistogram& late, int sector, std::ptrdiff_t offset,
                 std::span<float> signal) const;

  ResponseShape shape_;
  OctaveBank bank_;
  std::vector<float> edge_;  // [bin]: the fall of pulses towards the Nyquist frequency
  BandOverlap overlap_;
  NoisePool pool_;
  std::uint64_t seed_;
};

}  // namespace earpoint
