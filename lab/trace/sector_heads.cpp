#include "sector_heads.h"

#include "hrir_shifter.h"

#include <algorithm>
#include <cmath>

#include <earpoint/spatial/octave_bands.h>

namespace earpoint {
namespace {

constexpr int kShortestBlock = 2048;

// Both complex factors by parts, as std::complex tests for infinities.
void add_product(std::span<const std::complex<float>> a, std::span<const std::complex<float>> b,
                 std::span<std::complex<float>> sum) {
  for (std::size_t i = 0; i < sum.size(); ++i) {
    sum[i] += std::complex<float>(a[i].real() * b[i].real() - a[i].imag() * b[i].imag(),
                                  a[i].real() * b[i].imag() + a[i].imag() * b[i].real());
  }
}

}  // namespace

SectorHeads::SectorHeads(int sample_rate_hz, const Quaternion& world_from_listener,
                         const HrtfSet& hrtf) {
  HrirShifter shifter(hrtf.taps());
  fft_size_ = fast_fft_size(std::max(kShortestBlock, 4 * shifter.size()));
  hop_ = fft_size_ - shifter.size();
  const double position = -hrtf.centre_delay_samples();
  const double whole = std::floor(position);
  start_ = static_cast<int>(whole) - shifter.lead();
  RealFft<float> fft(fft_size_);
  const OctaveBank bank(sample_rate_hz, fft_size_);
  BandArray all{};
  for (int band = 0; band < kOctaveBands; ++band) {
    for (const float weight : bank.weights(band)) all[band] += weight * weight;
  }
  const Quaternion listener_from_world = conjugate(world_from_listener);
  std::vector<float> padded(fft_size_);
  for (int sector = 0; sector < kSectors; ++sector) {
    const Hrir hrir = hrtf.interpolated(rotate(listener_from_world, sector_direction(sector)));
    for (int ear = 0; ear < 2; ++ear) {
      std::fill(padded.begin(), padded.end(), 0.0F);
      shifter.shift(hrir.taps[ear], position - whole, std::span(padded).first(shifter.size()));
      Spectrum& spectrum = spectra_[sector][ear];
      spectrum.resize(fft.bins());
      fft.forward(padded, spectrum);
      for (int band = 0; band < kOctaveBands; ++band) {
        const std::span<const float> weights = bank.weights(band);
        float passed = 0.0F;
        for (std::size_t bin = 0; bin < spectrum.size(); ++bin) {
          passed += weights[bin] * weights[bin] * std::norm(spectrum[bin]);
        }
        energy_[sector][band] += passed / all[band];
      }
    }
  }
}

SectorMix::SectorMix(const SectorHeads& heads, int samples)
    : heads_(&heads),
      samples_(samples),
      fft_(heads.fft_size()),
      block_(fft_.size()),
      spectrum_(fft_.bins()),
      sums_((samples + heads.hop() - 1) / heads.hop()) {
  for (auto& sum : sums_) sum.fill(SectorHeads::Spectrum(fft_.bins()));
}

void SectorMix::add(int sector, std::span<const float> sound) {
  for (std::size_t block = 0; block < sums_.size(); ++block) {
    const std::span<const float> rest = sound.subspan(block * heads_->hop());
    const std::span<const float> part =
        rest.first(std::min(rest.size(), static_cast<std::size_t>(heads_->hop())));
    std::fill(std::copy(part.begin(), part.end(), block_.begin()), block_.end(), 0.0F);
    fft_.forward(block_, spectrum_);
    for (int ear = 0; ear < 2; ++ear) {
      add_product(spectrum_, heads_->spectrum(sector, ear), sums_[block][ear]);
    }
  }
}

std::vector<std::vector<float>> SectorMix::ears() {
  std::vector<std::vector<float>> ears(2, std::vector<float>(samples_));
  for (std::size_t block = 0; block < sums_.size(); ++block) {
    const std::ptrdiff_t start =
        static_cast<std::ptrdiff_t>(block) * heads_->hop() + heads_->start();
    for (int ear = 0; ear < 2; ++ear) {
      fft_.inverse(sums_[block][ear], block_);
      const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, -start);
      const std::ptrdiff_t last = std::min(std::ssize(block_), samples_ - start);
      for (std::ptrdiff_t i = first; i < last; ++i) ears[ear][start + i] += block_[i];
    }
  }
  return ears;
}

}  // namespace earpoint
