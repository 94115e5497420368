#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <earpoint/core/octave_bands.h>
#include <earpoint/trace/energy_histogram.h>

namespace earpoint {

/// A long stretch of white noise, split into the bands of the octave bank, joined at its ends.
class NoisePool {
 public:
  /// @param samples  of a response; the pool holds four of them, within bounds
  NoisePool(int sample_rate_hz, int samples, std::uint64_t seed);

  [[nodiscard]] std::ptrdiff_t size() const { return size_; }
  /// @return shape [size]
  [[nodiscard]] std::span<const float> band(int band) const {
    return std::span(noise_).subspan(static_cast<std::size_t>(band) * size_, size_);
  }

 private:
  std::ptrdiff_t size_;
  std::vector<float> noise_;  // [band][sample]
};

/// Energy over time in one band, at points `hop` samples apart and linear in between.
struct EnergyEnvelope {
  double hop_samples = 0.0;
  double first_samples = 0.0;  ///< where the first point lies
  std::vector<float> power;    ///< energy per sample
};

/// @param power  energy per sample in each histogram bin
EnergyEnvelope make_envelope(std::span<const BandArray> power, double bin_samples, int band);

/// Adds noise under an envelope.
/// @param noise  of one band, read from `offset` on, round its end
void add_shaped_noise(const EnergyEnvelope& envelope, std::span<const float> noise,
                      std::ptrdiff_t offset, std::span<float> signal);

}  // namespace earpoint
