#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include <fmt/format.h>

#include <earpoint/audio/envelope.h>
#include <earpoint/audio/fft.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/response_metrics.h>

#include "reflected_stft.h"

namespace earpoint {
namespace {

constexpr const char* kWhere = "impulse responses";

using Channel = std::span<const float>;

constexpr int kSummedBins = 32;
constexpr std::array<StftShape, 3> kResolutions{StftShape{512, 300, 60, Window::hann},
                                                StftShape{256, 150, 30, Window::hann},
                                                StftShape{128, 75, 8, Window::hann}};

/// Every bin of a response's Fourier transform, [samples].
std::vector<std::complex<double>> spectrum_of(Channel response) {
  const auto size = static_cast<int>(response.size());
  RealFft<double> fft(size);
  const std::vector<double> samples(response.begin(), response.end());
  std::vector<std::complex<double>> spectrum(fft.bins());
  fft.forward(samples, spectrum);
  for (int k = size - fft.bins(); k > 0; --k) spectrum.push_back(std::conj(spectrum[k]));
  return spectrum;
}

std::complex<double> direction(std::complex<double> value) {
  const double magnitude = std::abs(value);
  return magnitude > 0.0 ? value / magnitude : 1.0;
}

/// Sums of 32 bins, 15 before each to 16 after, the spectrum mirrored at its ends.
std::vector<double> summed_magnitudes(std::span<const std::complex<double>> spectrum) {
  const std::ptrdiff_t size = std::ssize(spectrum);
  const auto magnitude = [&](std::ptrdiff_t bin) {
    if (bin < 0) bin = -1 - bin;
    if (bin >= size) bin = 2 * size - 1 - bin;
    return std::abs(spectrum[bin]);
  };
  std::vector<double> sums(spectrum.size());
  for (std::ptrdiff_t k = 0; k < size; ++k) {
    for (int j = 1 - kSummedBins / 2; j <= kSummedBins / 2; ++j) sums[k] += magnitude(k + j);
  }
  return sums;
}

/// What the decay of one response tells.
struct Decay {
  std::optional<double> t60_s;
  double edt_s = 0.0;
  double c50_db = 0.0;
};

/// The sample whose level is nearest to one, the first of several.
std::size_t nearest(std::span<const float> curve, float level_db) {
  const auto found = std::ranges::min_element(
      curve, {}, [level_db](float level) { return std::abs(level - level_db); });
  return static_cast<std::size_t>(found - curve.begin());
}

std::vector<float> decay_curve_db(Channel response) {
  std::vector<float> curve(response.size());
  float sum = 0.0F;
  for (std::size_t i = response.size(); i-- > 0;) {
    sum += response[i] * response[i] + 1e-9F;
    curve[i] = sum;
  }
  for (float& level : curve) level = 10.0F * std::log10(level);
  const float whole = curve.front();
  for (float& level : curve) level -= whole;
  return curve;
}

/// The slope of the regression line through a part of the curve, dB a sample.
std::optional<double> slope_db(std::span<const float> part) {
  if (part.size() < 2) return std::nullopt;
  const double middle = static_cast<double>(part.size() - 1) / 2.0;
  double products = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < part.size(); ++i) {
    const double x = static_cast<double>(i) - middle;
    products += x * part[i];
    squares += x * x;
  }
  return products / squares;
}

Decay decay_of(Channel response, int rate_hz) {
  const std::vector<float> curve = decay_curve_db(response);
  Decay decay;
  decay.edt_s = 6.0 * static_cast<double>(nearest(curve, -10.0F)) / rate_hz;
  const std::size_t from = nearest(curve, -5.0F);
  const std::size_t to = nearest(curve, -25.0F);
  const auto slope = slope_db(std::span(curve).subspan(from, to + 1 - from));
  if (slope) decay.t60_s = 3.0 * -20.0 / *slope / rate_hz;

  const auto split = static_cast<std::size_t>(0.05 * rate_hz);
  double early = 0.0;
  double late = 0.0;
  for (std::size_t i = 0; i < response.size(); ++i) {
    (i < split ? early : late) += double{response[i]} * response[i];
  }
  decay.c50_db = 10.0 * std::log10(early / late);
  return decay;
}

void compare_spectra(Channel reference, Channel estimate, double share, AvrMetrics& metrics) {
  const auto a = spectrum_of(reference);
  const auto b = spectrum_of(estimate);
  const std::vector<double> sums = summed_magnitudes(a);
  const std::vector<double> others = summed_magnitudes(b);
  double phase = 0.0;
  double amp = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const std::complex<double> turn = direction(a[k]) - direction(b[k]);
    phase += std::abs(turn.real()) + std::abs(turn.imag());
    amp += std::abs(sums[k] - others[k]) / sums[k];
  }
  metrics.phase += share * phase / static_cast<double>(a.size());
  metrics.amp += share * amp / static_cast<double>(a.size());
}

double envelope_error(Channel reference, Channel estimate) {
  const std::vector<double> a = hilbert_envelope(reference);
  const std::vector<double> b = hilbert_envelope(estimate);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / static_cast<double>(a.size()) / std::ranges::max(a);
}

/// Sums of one resolution over the channels of a batch.
struct SpectralSums {
  double squared_difference = 0.0;
  double squared_estimate = 0.0;
  double logarithmic = 0.0;
  double linear = 0.0;
  double count = 0.0;

  void add(const StftShape& shape, Channel reference, Channel estimate) {
    constexpr float kMinPower = 1e-8F;
    const PowerSpectrogram a = reflected_power(shape, reference);
    const PowerSpectrogram b = reflected_power(shape, estimate);
    for (std::size_t i = 0; i < a.values.size(); ++i) {
      const double x = std::sqrt(double{std::max(a.values[i], kMinPower)});
      const double y = std::sqrt(double{std::max(b.values[i], kMinPower)});
      squared_difference += (y - x) * (y - x);
      squared_estimate += y * y;
      logarithmic += std::abs(std::log(x) - std::log(y));
      linear += std::abs(x - y);
    }
    count += static_cast<double>(a.values.size());
  }
  [[nodiscard]] double loss() const {
    return std::sqrt(squared_difference / squared_estimate) + (logarithmic + linear) / count;
  }
};

double multi_resolution_loss(const ResponsePair& pair) {
  double loss = 0.0;
  for (const StftShape& shape : kResolutions) {
    SpectralSums sums;
    for (int c = 0; c < pair.reference.channels(); ++c) {
      sums.add(shape, pair.reference.channel(c), pair.estimate.channel(c));
    }
    loss += sums.loss() / kResolutions.size();
  }
  return loss;
}

}  // namespace

AvrMetrics avr_metrics(const ResponsePair& pair) {
  const std::ptrdiff_t least = kResolutions.front().fft_size / 2 + 1;
  if (pair.reference.samples() < least) {
    throw InputError(kWhere,
                     fmt::format("have {} samples, avr needs {}", pair.reference.samples(), least));
  }
  const int rate_hz = pair.reference.sample_rate_hz();
  const double share = 1.0 / pair.reference.channels();
  AvrMetrics metrics;
  std::optional<double> t60_percent = 0.0;
  double c50_db = 0.0;
  for (int c = 0; c < pair.reference.channels(); ++c) {
    const Channel reference = pair.reference.channel(c);
    const Channel estimate = pair.estimate.channel(c);
    if (std::ranges::all_of(reference, [](float x) { return x == 0.0F; })) {
      throw InputError(kWhere, fmt::format("channel {} of the reference is silent", c));
    }
    compare_spectra(reference, estimate, share, metrics);
    metrics.env += share * envelope_error(reference, estimate);
    const Decay a = decay_of(reference, rate_hz);
    const Decay b = decay_of(estimate, rate_hz);
    metrics.edt_error_s += share * std::abs(a.edt_s - b.edt_s);
    c50_db += share * std::abs(a.c50_db - b.c50_db);
    t60_percent =
        t60_percent && a.t60_s && b.t60_s
            ? std::optional(*t60_percent + 100.0 * share * std::abs(*a.t60_s - *b.t60_s) / *a.t60_s)
            : std::nullopt;
  }
  metrics.t60_error_percent = t60_percent;
  if (std::isfinite(c50_db)) metrics.c50_error_db = c50_db;
  metrics.multi_stft = multi_resolution_loss(pair);
  return metrics;
}

}  // namespace earpoint
