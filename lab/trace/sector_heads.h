#pragma once

#include <array>
#include <complex>
#include <span>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/core/octave_bands.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/hrtf.h>
#include <earpoint/trace/energy_histogram.h>

namespace earpoint {

/// The HRTFs of the sectors' middles for one turn of the head, as spectra of a block.
class SectorHeads {
 public:
  using Spectrum = std::vector<std::complex<float>>;

  SectorHeads(int sample_rate_hz, const Quaternion& world_from_listener, const HrtfSet& hrtf);

  /// Samples of a block with its response.
  [[nodiscard]] int fft_size() const { return fft_size_; }
  /// New samples in each block.
  [[nodiscard]] int hop() const { return hop_; }
  /// Where the filtered block starts, relative to the block: the responses are placed by the time
  /// at the middle of the head.
  [[nodiscard]] int start() const { return start_; }
  /// @return shape [fft_size / 2 + 1]
  [[nodiscard]] const Spectrum& spectrum(int sector, int ear) const {
    return spectra_[sector][ear];
  }
  /// @return the share of each band's energy that the two ears get together
  [[nodiscard]] const BandArray& energy(int sector) const { return energy_[sector]; }

 private:
  int fft_size_ = 0;
  int hop_ = 0;
  int start_ = 0;
  std::array<std::array<Spectrum, 2>, kSectors> spectra_;
  std::array<BandArray, kSectors> energy_{};
};

/// Sends the sectors' sounds through their HRTFs, block by block, and adds them up.
class SectorMix {
 public:
  /// @param heads    must live as long as this
  /// @param samples  of every sound
  SectorMix(const SectorHeads& heads, int samples);

  /// @param sound  shape [samples]
  void add(int sector, std::span<const float> sound);

  /// @return [ear][samples]
  [[nodiscard]] std::vector<std::vector<float>> ears();

 private:
  const SectorHeads* heads_;
  int samples_;
  RealFft<float> fft_;
  std::vector<float> block_;
  SectorHeads::Spectrum spectrum_;
  std::vector<std::array<SectorHeads::Spectrum, 2>> sums_;  // [block][ear]
};

}  // namespace earpoint
