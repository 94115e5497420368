#include <earpoint/evaluate/speech_metrics.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <earpoint/audio/fft.h>
#include <earpoint/audio/resample.h>
#include <earpoint/error.h>
#include <earpoint/waveform.h>

namespace earpoint {
namespace {

constexpr int kRateHz = Estoi::kLowestRate_hz;
constexpr int kFrame = 256;
constexpr int kHop = 128;
constexpr int kTransform = 512;
constexpr int kBands = 15;
constexpr double kLowestCentreHz = 150.0;
constexpr int kSegmentFrames = 30;
constexpr double kRangeDb = 40.0;

double dot(std::span<const float> a, std::span<const float> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += double{a[i]} * b[i];
  return sum;
}

std::vector<float> at_10_khz(std::span<const float> sound, int rate_hz) {
  Waveform wave(1, std::ssize(sound), rate_hz);
  std::ranges::copy(sound, wave.channel(0).begin());
  wave = resample(wave, kRateHz);
  return {wave.channel(0).begin(), wave.channel(0).end()};
}

/// Where a frame begins, for every whole frame.
std::vector<std::size_t> frame_starts(std::size_t samples) {
  std::vector<std::size_t> starts;
  for (std::size_t start = 0; start + kFrame <= samples; start += kHop) starts.push_back(start);
  return starts;
}

/// Square roots of the powers of third-octave bands, [bands][frames].
using Bands = std::vector<std::vector<double>>;

/// Removes the mean and divides by the norm; constants become zero.
template <typename Values>
void normalise(const Values& at, int count) {
  double mean = 0.0;
  for (int i = 0; i < count; ++i) mean += at(i) / count;
  double energy = 0.0;
  for (int i = 0; i < count; ++i) {
    at(i) -= mean;
    energy += at(i) * at(i);
  }
  // What a constant leaves is rounding.
  const bool is_constant = energy <= 1e-24 * (mean * mean) * count;
  const double scale = is_constant || energy == 0.0 ? 0.0 : 1.0 / std::sqrt(energy);
  for (int i = 0; i < count; ++i) at(i) *= scale;
}

using Segment = std::array<std::array<double, kSegmentFrames>, kBands>;

/// Frames `first`... of all bands, normalised along time in every band, then along the bands in
/// every frame.
Segment normalised_segment(const Bands& bands, std::size_t first) {
  Segment segment{};
  for (int b = 0; b < kBands; ++b) {
    std::copy_n(bands[b].begin() + static_cast<std::ptrdiff_t>(first), kSegmentFrames,
                segment[b].begin());
    normalise([&](int t) -> double& { return segment[b][t]; }, kSegmentFrames);
  }
  for (int t = 0; t < kSegmentFrames; ++t) {
    normalise([&](int b) -> double& { return segment[b][t]; }, kBands);
  }
  return segment;
}

}  // namespace

std::optional<double> si_sdr_db(std::span<const float> reference, std::span<const float> estimate) {
  EARPOINT_CHECK(reference.size() == estimate.size());
  const double reference_energy = dot(reference, reference);
  if (reference_energy == 0.0 || dot(estimate, estimate) == 0.0) return std::nullopt;
  const double scale = dot(reference, estimate) / reference_energy;
  double distortion = 0.0;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    const double difference = scale * reference[i] - estimate[i];
    distortion += difference * difference;
  }
  const double kept = scale * scale * reference_energy;
  const double largest = std::pow(10.0, kLargestSiSdrDb / 10.0);
  if (kept >= largest * distortion) return kLargestSiSdrDb;
  if (distortion >= largest * kept) return -kLargestSiSdrDb;
  return 10.0 * std::log10(kept / distortion);
}

struct Estoi::State {
  State() : fft(kTransform), input(kTransform), spectrum(static_cast<std::size_t>(fft.bins())) {
    // Hann without its zeros at both ends.
    for (int n = 1; n <= kFrame; ++n) {
      window.push_back(0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * n / (kFrame + 1)));
    }
    const auto nearest_bin = [](double hz) {
      return static_cast<std::size_t>(std::lround(hz * kTransform / kRateHz));
    };
    for (int b = 0; b < kBands; ++b) {
      first_bin[b] = nearest_bin(kLowestCentreHz * std::pow(2.0, (2.0 * b - 1.0) / 6.0));
      end_bin[b] = nearest_bin(kLowestCentreHz * std::pow(2.0, (2.0 * b + 1.0) / 6.0));
    }
  }

  /// The frames of the reference that are loud enough.
  [[nodiscard]] std::vector<std::size_t> speech_frames(const std::vector<float>& reference) const {
    const std::vector<std::size_t> starts = frame_starts(reference.size());
    std::vector<double> energies;
    for (const std::size_t start : starts) {
      double energy = 0.0;
      for (int n = 0; n < kFrame; ++n) {
        const double x = window[n] * reference[start + n];
        energy += x * x;
      }
      energies.push_back(energy);
    }
    std::vector<std::size_t> kept;
    if (energies.empty()) return kept;
    const double threshold = *std::ranges::max_element(energies) * std::pow(10.0, -kRangeDb / 10.0);
    for (std::size_t i = 0; i < starts.size(); ++i) {
      if (energies[i] > threshold) kept.push_back(starts[i]);
    }
    return kept;
  }

  /// The given frames of a sound, windowed and overlap-added as if they were adjacent.
  [[nodiscard]] std::vector<double> joined(const std::vector<float>& sound,
                                           const std::vector<std::size_t>& frames) const {
    if (frames.empty()) return {};
    std::vector<double> result((frames.size() - 1) * kHop + kFrame);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      for (int n = 0; n < kFrame; ++n) {
        result[i * kHop + n] += window[n] * sound[frames[i] + n];
      }
    }
    return result;
  }

  Bands bands_of(const std::vector<double>& sound) {
    const std::vector<std::size_t> starts = frame_starts(sound.size());
    Bands bands(kBands, std::vector<double>(starts.size()));
    for (std::size_t i = 0; i < starts.size(); ++i) {
      std::ranges::fill(input, 0.0);
      for (int n = 0; n < kFrame; ++n) input[n] = window[n] * sound[starts[i] + n];
      fft.forward(input, spectrum);
      for (int b = 0; b < kBands; ++b) {
        double power = 0.0;
        for (std::size_t k = first_bin[b]; k < end_bin[b]; ++k) power += std::norm(spectrum[k]);
        bands[b][i] = std::sqrt(power);
      }
    }
    return bands;
  }

  RealFft<double> fft;
  std::vector<double> window;
  std::vector<double> input;
  std::vector<std::complex<double>> spectrum;
  std::array<std::size_t, kBands> first_bin{};
  std::array<std::size_t, kBands> end_bin{};
};

Estoi::Estoi() : state_(std::make_unique<State>()) {}
Estoi::~Estoi() = default;
Estoi::Estoi(Estoi&&) noexcept = default;
Estoi& Estoi::operator=(Estoi&&) noexcept = default;

std::optional<double> Estoi::measure(std::span<const float> reference,
                                     std::span<const float> estimate, int sample_rate_hz) {
  EARPOINT_CHECK(reference.size() == estimate.size() && sample_rate_hz >= kRateHz);
  State& s = *state_;
  const std::vector<float> clean = at_10_khz(reference, sample_rate_hz);
  const std::vector<std::size_t> frames = s.speech_frames(clean);
  if (frames.size() < kSegmentFrames) return std::nullopt;
  const Bands a = s.bands_of(s.joined(clean, frames));
  const Bands b = s.bands_of(s.joined(at_10_khz(estimate, sample_rate_hz), frames));
  const std::size_t segments = a.front().size() - kSegmentFrames + 1;
  double sum = 0.0;
  for (std::size_t first = 0; first < segments; ++first) {
    const Segment x = normalised_segment(a, first);
    const Segment y = normalised_segment(b, first);
    for (int band = 0; band < kBands; ++band) {
      for (int t = 0; t < kSegmentFrames; ++t) sum += x[band][t] * y[band][t];
    }
  }
  return sum / (kSegmentFrames * static_cast<double>(segments));
}

}  // namespace earpoint
