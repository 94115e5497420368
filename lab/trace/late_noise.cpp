#include "late_noise.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include <earpoint/audio/fft.h>
#include <earpoint/core/random.h>
#include <earpoint/error.h>
#include <earpoint/spatial/octave_bands.h>

namespace earpoint {
namespace {

// 8 to 33 s at 16 kHz.
constexpr int kSmallestPool = 1 << 17;
constexpr int kLargestPool = 1 << 19;

// Histogram bins per point of an envelope. A low band's noise cannot follow faster changes: a
// faster envelope would spread its energy into the bands above.
constexpr std::array<int, kOctaveBands> kBinsPerPoint = {4, 2, 1, 1, 1, 1, 1, 1};

}  // namespace

NoisePool::NoisePool(int sample_rate_hz, int samples, std::uint64_t seed) {
  constexpr int kResponses = 4;
  int size = kSmallestPool;
  while (size < kLargestPool && size / kResponses < samples) size *= 2;
  size_ = size;
  std::vector<float> white(size);
  RandomStream random(seed);
  for (float& sample : white) sample = static_cast<float>(random.normal());
  RealFft<float> fft(size);
  std::vector<std::complex<float>> spectrum(fft.bins());
  std::vector<std::complex<float>> part(fft.bins());
  fft.forward(white, spectrum);
  noise_.resize(static_cast<std::size_t>(kOctaveBands) * size);
  const OctaveBank bank(sample_rate_hz, size);
  for (int band = 0; band < kOctaveBands; ++band) {
    const std::span<const float> weights = bank.weights(band);
    for (std::size_t bin = 0; bin < part.size(); ++bin) part[bin] = spectrum[bin] * weights[bin];
    fft.inverse(part, std::span(noise_).subspan(static_cast<std::size_t>(band) * size_, size_));
  }
}

EnergyEnvelope make_envelope(std::span<const BandArray> power, double bin_samples, int band) {
  const int bins_per_point = kBinsPerPoint[band];
  EnergyEnvelope envelope;
  envelope.hop_samples = bin_samples * bins_per_point;
  envelope.first_samples = envelope.hop_samples / 2.0;
  const std::size_t points = (power.size() + bins_per_point - 1) / bins_per_point;
  envelope.power.assign(points, 0.0F);
  for (std::size_t bin = 0; bin < power.size(); ++bin) {
    envelope.power[bin / bins_per_point] += power[bin][band] / static_cast<float>(bins_per_point);
  }
  return envelope;
}

void add_shaped_noise(const EnergyEnvelope& envelope, std::span<const float> noise,
                      std::ptrdiff_t offset, std::span<float> signal) {
  const auto points = std::ssize(envelope.power);
  // Segment k runs from point k - 1 to point k; outside of them there is no energy.
  for (std::ptrdiff_t k = 0; k <= points; ++k) {
    const float from = k > 0 ? envelope.power[k - 1] : 0.0F;
    const float to = k < points ? envelope.power[k] : 0.0F;
    if (from == 0.0F && to == 0.0F) continue;
    const double start =
        envelope.first_samples + (static_cast<double>(k) - 1.0) * envelope.hop_samples;
    const auto begin = static_cast<std::ptrdiff_t>(std::max(0.0, std::ceil(start)));
    const std::ptrdiff_t end = std::min(
        std::ssize(signal), static_cast<std::ptrdiff_t>(std::ceil(start + envelope.hop_samples)));
    const auto slope = static_cast<float>((to - from) / envelope.hop_samples);
    const auto first = static_cast<float>(static_cast<double>(begin) - start);
    std::ptrdiff_t place = (begin + offset) % std::ssize(noise);
    std::ptrdiff_t done = begin;
    while (done < end) {
      const std::ptrdiff_t run = std::min(end - done, std::ssize(noise) - place);
      const float* in = &noise[place];
      float* out = &signal[done];
      const float power = from + slope * (first + static_cast<float>(done - begin));
      for (std::ptrdiff_t i = 0; i < run; ++i) {
        out[i] += std::sqrt(std::max(0.0F, power + slope * static_cast<float>(i))) * in[i];
      }
      done += run;
      place = 0;
    }
  }
}

}  // namespace earpoint
