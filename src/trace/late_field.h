#pragma once

#include "late_level.h"
#include "late_noise.h"
#include "pulse_train.h"

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/core/pose.h>
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

/// Sound without a path of its own: the noise of the energy histogram, and arrivals too many to be
/// told apart, by sector.
class LateField {
 public:
  LateField(const ResponseShape& shape, std::uint64_t seed);

  /// Adds what an omnidirectional microphone hears.
  /// @param dense     arrivals, by delay
  /// @param signal    shape [samples]
  void add_mono(const EnergyHistogram& late, std::span<const Arrival> dense, std::uint64_t stream,
                std::span<float> signal) const;

  /// Adds what two ears hear: each sector's sound through the HRTF of its middle.
  /// @param ears  [ear][samples]
  void add_binaural(const EnergyHistogram& late, std::span<const Arrival> dense,
                    const Quaternion& world_from_listener, const HrtfSet& hrtf,
                    std::uint64_t stream, std::span<std::vector<float>> ears) const;

 private:
  struct SectorFilters;
  using Spectrum = std::vector<std::complex<float>>;

  void add_noise(const EnergyHistogram& late, int sector, std::ptrdiff_t offset,
                 std::span<float> signal) const;
  void add_pulses(std::span<const Arrival> arrivals, PulseTrain& train, Spectrum& sum) const;
  [[nodiscard]] SectorFilters sector_filters(const Quaternion& world_from_listener,
                                             const HrtfSet& hrtf, RealFft<float>& fft) const;

  ResponseShape shape_;
  OctaveBank bank_;
  BandOverlap overlap_;
  NoisePool pool_;
  std::uint64_t seed_;
};

}  // namespace earpoint
