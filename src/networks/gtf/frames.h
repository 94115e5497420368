#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/gtf/description.h>

namespace earpoint::gtf {

/// Both ears' sound as short-time spectra, and back. Frame t has its middle at sample t * hop.
class GtfFrames {
 public:
  /// @param most_frames  that add() is called for between two calls of drain()
  explicit GtfFrames(std::ptrdiff_t most_frames);

  /// Restarts at sample 0. Allocates nothing.
  void reset();

  /// The spectrum of the frame whose middle is `sound[centre]`, zeros outside. Allocates nothing.
  /// @param sound     one ear
  /// @param spectrum  [bins]
  void transform(std::span<const float> sound, std::ptrdiff_t centre, float scale,
                 std::span<std::complex<float>> spectrum);

  /// Overlaps the next frame with those before. Allocates nothing.
  /// @param spectra  [2][bins]
  void add(std::span<const std::complex<float>> spectra, float scale);

  /// How many samples no later frame will change.
  [[nodiscard]] std::ptrdiff_t finished_samples() const;

  /// Takes finished samples out; each may be taken once, in order. Allocates nothing.
  /// @param output  planar, ears `stride` apart
  void drain(std::ptrdiff_t start, std::ptrdiff_t count, float* output, std::ptrdiff_t stride);

 private:
  std::array<float, GtfDescription::kFrameSamples> window_;
  RealFft<float> fft_{GtfDescription::kFftSize};
  std::array<float, GtfDescription::kFftSize> frame_{};
  std::ptrdiff_t frames_ = 0;
  std::ptrdiff_t size_;        ///< of the ring
  std::vector<float> ring_;    ///< [2][size]
  std::vector<float> weight_;  ///< [size]
};

}  // namespace earpoint::gtf
