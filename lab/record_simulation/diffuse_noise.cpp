#include "diffuse_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include <earpoint/audio/convolution.h>
#include <earpoint/audio/fft.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr int kTaps = 2048;
constexpr int kBins = kTaps / 2 + 1;
constexpr double kLowest_hz = 60.0;
constexpr double kHighest_hz = 12000.0;
constexpr int kDirections = 256;

using Spectrum = std::vector<std::complex<float>>;

/// Amplitude of pink noise, faded out over an octave beyond its band.
double pink(double frequency_hz) {
  if (frequency_hz <= 0.0) return 0.0;
  const double octaves =
      std::max(std::log2(kLowest_hz / frequency_hz), std::log2(frequency_hz / kHighest_hz));
  const double fade = 0.5 + 0.5 * std::cos(kPi * std::clamp(octaves, 0.0, 1.0));
  return fade / std::sqrt(frequency_hz);
}

double bin_hz(int bin, int rate_hz) { return static_cast<double>(bin) * rate_hz / kTaps; }

/// The windowed filter of that spectrum, with time 0 in the middle.
std::vector<float> filter_of(const Spectrum& spectrum) {
  RealFft<float> fft(kTaps);
  std::vector<float> taps(kTaps);
  fft.inverse(spectrum, taps);
  std::rotate(taps.begin(), taps.begin() + kTaps / 2, taps.end());
  for (int i = 0; i < kTaps; ++i) {
    taps[i] *= static_cast<float>(0.5 - 0.5 * std::cos(2.0 * kPi * i / kTaps));
  }
  return taps;
}

/// Spectra at the ears in a diffuse field.
struct FieldAtEars {
  std::array<std::vector<double>, 2> powers;     // [ear][bin]
  std::vector<std::complex<double>> left_right;  // [bin]: mean of left times conj(right)
};

FieldAtEars field_at(const HrtfSet& ears) {
  FieldAtEars field;
  for (auto& power : field.powers) power.assign(kBins, 0.0);
  field.left_right.assign(kBins, 0.0);
  RealFft<float> fft(kTaps);
  std::array<Spectrum, 2> spectra = {Spectrum(kBins), Spectrum(kBins)};
  for (int i = 0; i < kDirections; ++i) {
    // Even over the sphere: a spiral in steps of the golden angle.
    const double z = 1.0 - (2.0 * i + 1.0) / kDirections;
    const double around = i * kPi * (3.0 - std::sqrt(5.0));
    const double across = std::sqrt(1.0 - z * z);
    const std::size_t measurement =
        ears.nearest({across * std::cos(around), across * std::sin(around), z});
    for (int ear = 0; ear < 2; ++ear) {
      std::vector<float> padded(kTaps);
      const std::span<const float> taps = ears.response(measurement, ear);
      std::copy_n(taps.begin(), std::min<std::size_t>(taps.size(), kTaps), padded.begin());
      fft.forward(padded, spectra[ear]);
    }
    for (int bin = 0; bin < kBins; ++bin) {
      const std::complex<double> left = spectra[0][bin];
      const std::complex<double> right = spectra[1][bin];
      field.powers[0][bin] += std::norm(left) / kDirections;
      field.powers[1][bin] += std::norm(right) / kDirections;
      field.left_right[bin] += left * std::conj(right) / static_cast<double>(kDirections);
    }
  }
  return field;
}

/// Makes the mean square of the outputs 1, for white noise of variance 1.
void normalize(std::vector<std::vector<std::vector<float>>>& filters) {
  double power = 0.0;
  for (const auto& output : filters) {
    for (const auto& taps : output) {
      for (const float tap : taps) power += static_cast<double>(tap) * tap;
    }
  }
  const auto scale = static_cast<float>(std::sqrt(static_cast<double>(filters.size()) / power));
  for (auto& output : filters) {
    for (auto& taps : output) {
      for (float& tap : taps) tap *= scale;
    }
  }
}

}  // namespace

DiffuseNoise::DiffuseNoise(int sample_rate_hz) : sample_rate_hz_(sample_rate_hz) {
  Spectrum spectrum(kBins);
  for (int bin = 0; bin < kBins; ++bin) {
    spectrum[bin] = static_cast<float>(pink(bin_hz(bin, sample_rate_hz)));
  }
  filters_ = {{filter_of(spectrum)}};
  normalize(filters_);
}

DiffuseNoise::DiffuseNoise(const HrtfSet& ears) : sample_rate_hz_(ears.sample_rate_hz()) {
  const FieldAtEars field = field_at(ears);
  // The left ear's noise, the coherent part of the right ear's, and the rest of it.
  Spectrum left(kBins);
  Spectrum shared(kBins);
  Spectrum own(kBins);
  for (int bin = 0; bin < kBins; ++bin) {
    const double level = pink(bin_hz(bin, sample_rate_hz_));
    const double amplitude = std::sqrt(field.powers[0][bin]);
    if (amplitude <= 0.0) continue;
    const std::complex<double> part = std::conj(field.left_right[bin]) / amplitude;
    const double rest = std::max(0.0, field.powers[1][bin] - std::norm(part));
    left[bin] = static_cast<float>(level * amplitude);
    shared[bin] = std::complex<float>(level * part);
    own[bin] = static_cast<float>(level * std::sqrt(rest));
  }
  filters_ = {{filter_of(left)}, {filter_of(shared), filter_of(own)}};
  normalize(filters_);
}

Waveform DiffuseNoise::make(std::ptrdiff_t samples, RandomStream& random) const {
  constexpr int kBlock = kTaps;
  const int channels = static_cast<int>(filters_.size());
  Waveform noise(channels, samples, sample_rate_hz_);
  std::vector<std::vector<PartitionedConvolver>> convolvers;
  for (const auto& output : filters_) {
    auto& row = convolvers.emplace_back();
    for (const auto& taps : output) row.emplace_back(taps, kBlock);
  }
  std::vector<std::vector<float>> white(filters_.back().size(), std::vector<float>(kBlock));
  std::vector<float> filtered(kBlock);
  // The first blocks fill the filters.
  for (std::ptrdiff_t begin = -kBlock; begin < samples; begin += kBlock) {
    for (auto& input : white) {
      for (float& sample : input) sample = static_cast<float>(random.normal());
    }
    for (int c = 0; c < channels; ++c) {
      for (std::size_t input = 0; input < convolvers[c].size(); ++input) {
        convolvers[c][input].process(white[input], filtered);
        const std::ptrdiff_t count = std::min<std::ptrdiff_t>(kBlock, samples - begin);
        for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, -begin); i < count; ++i) {
          noise.channel(c)[begin + i] += filtered[i];
        }
      }
    }
  }
  return noise;
}

}  // namespace earpoint
