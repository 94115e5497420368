#include <earpoint/evaluate/response_metrics.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <fmt/format.h>

#include <earpoint/audio/butterworth.h>
#include <earpoint/error.h>
#include <earpoint/pose.h>

#include "reflected_stft.h"

namespace earpoint {
namespace {

constexpr const char* kWhere = "impulse responses";

constexpr int kNafRateHz = 22050;
constexpr std::size_t kNafMinLength = 4410;
constexpr StftShape kNafShape{512, 512, 128, Window::hann};
constexpr double kHighpassHz = 200.0;
constexpr double kHighpassQuality = 0.707;

using Channel = std::span<const float>;

/// Energies from each sample to the end in dB below the whole, without the silence at the end and
/// the last sample that is not silent.
/// @tparam Real  the precision of the sums, which decides near a level which sample is below it
template <typename Real>
std::vector<Real> schroeder_db(Channel response) {
  std::vector<Real> curve(response.size());
  Real sum = 0;
  std::size_t last = 0;
  for (std::size_t i = response.size(); i-- > 0;) {
    sum += static_cast<Real>(response[i]) * static_cast<Real>(response[i]);
    curve[i] = sum;
    if (last == 0 && sum > 0) last = i;
  }
  curve.resize(last);
  for (Real& level : curve) level = 10 * std::log10(level);
  const Real whole = curve.empty() ? 0 : curve.front();
  for (Real& level : curve) level -= whole;
  return curve;
}

/// The first sample below a level. @return nothing if there is none
template <typename Real>
std::optional<double> first_below(const std::vector<Real>& curve, double level_db) {
  const auto found = std::ranges::find_if(curve, [&](Real x) { return x < level_db; });
  if (found == curve.end()) return std::nullopt;
  return static_cast<double>(found - curve.begin());
}

/// 60 dB over the fall, times how long it takes from -5 dB on.
template <typename Real>
std::optional<double> two_point_t60_s(Channel response, double fall_db, int rate_hz) {
  const std::vector<Real> curve = schroeder_db<Real>(response);
  const auto from = first_below(curve, -5.0);
  const auto to = first_below(curve, -5.0 - fall_db);
  if (!from || !to) return std::nullopt;
  return 60.0 / fall_db * (*to - *from) / rate_hz;
}

std::optional<double> early_decay_s(Channel response, int rate_hz) {
  const auto sample = first_below(schroeder_db<float>(response), -10.0);
  if (!sample) return std::nullopt;
  return 6.0 * *sample / rate_hz;
}

double clarity_db(Channel response, int rate_hz) {
  const auto split = std::min(response.size(), static_cast<std::size_t>(0.05 * rate_hz + 1.0));
  double early = 0.0;
  double late = 0.0;
  for (std::size_t i = 0; i < response.size(); ++i) {
    (i < split ? early : late) += double{response[i]} * response[i];
  }
  return 10.0 * std::log10(early / late);
}

/// The mean over the channels of a difference; nothing where a channel has no finite value.
template <typename Measure>
std::optional<double> mean_difference(const ResponsePair& pair, const Measure& measure) {
  double sum = 0.0;
  for (int c = 0; c < pair.reference.channels(); ++c) {
    const std::optional<double> a = measure(pair.reference.channel(c));
    const std::optional<double> b = measure(pair.estimate.channel(c));
    if (!a || !b) return std::nullopt;
    sum += std::abs(*a - *b);
  }
  if (!std::isfinite(sum)) return std::nullopt;
  return sum / pair.reference.channels();
}

struct T60Error {
  std::optional<double> percent;
  bool invalid = false;
};

/// A response without such a decay makes the whole pair count as 100 %.
template <typename Measure>
T60Error t60_error(const ResponsePair& pair, const Measure& measure) {
  double sum = 0.0;
  for (int c = 0; c < pair.reference.channels(); ++c) {
    const std::optional<double> a = measure(pair.reference.channel(c));
    const std::optional<double> b = measure(pair.estimate.channel(c));
    if (!a || !b) return {100.0, true};
    sum += std::abs(*a - *b) / *a;
  }
  if (!std::isfinite(sum)) return {};
  return {100.0 * sum / pair.reference.channels(), false};
}

/// The mean of | ln(|S| + 1e-3) - ln(|S'| + 1e-3) | over the first frames and bins.
double log_difference(const PowerSpectrogram& a, const PowerSpectrogram& b, int frames, int bins) {
  constexpr double kFloor = 1e-3;
  const auto level = [](float power) { return std::log(std::sqrt(double{power}) + kFloor); };
  double sum = 0.0;
  for (int k = 0; k < frames; ++k) {
    for (int i = 0; i < bins; ++i) {
      const auto at = static_cast<std::size_t>(k) * a.bins + i;
      sum += std::abs(level(a.values[at]) - level(b.values[at]));
    }
  }
  return sum / (static_cast<double>(frames) * bins);
}

/// SoX's high-pass of second order, its output clamped to full scale, as torchaudio has it.
std::vector<float> highpassed(Channel response, int rate_hz) {
  const double w = 2.0 * kPi * kHighpassHz / rate_hz;
  const double alpha = std::sin(w) / (2.0 * kHighpassQuality);
  const double a0 = 1.0 + alpha;
  const SecondOrderSection section{.b0 = (1.0 + std::cos(w)) / 2.0 / a0,
                                   .b1 = -(1.0 + std::cos(w)) / a0,
                                   .b2 = (1.0 + std::cos(w)) / 2.0 / a0,
                                   .a1 = -2.0 * std::cos(w) / a0,
                                   .a2 = (1.0 - alpha) / a0};
  SectionFilter filter(std::span(&section, 1));
  std::vector<float> out;
  out.reserve(response.size());
  for (const float x : response) {
    out.push_back(static_cast<float>(std::clamp(filter.process(x), -1.0, 1.0)));
  }
  return out;
}

StftShape raf_shape(int rate_hz) {
  return rate_hz == 48000 ? StftShape{1024, 512, 256, Window::hann}
                          : StftShape{512, 256, 128, Window::hann};
}

Waveform clamped(Waveform wave) {
  for (float& x : wave.planar()) x = std::clamp(x, -1.0F, 1.0F);
  return wave;
}

PowerSpectrogram naf_spectrum(Channel response) {
  std::vector<float> extended(response.begin(), response.end());
  extended.resize(std::max(response.size() + kNafShape.fft_size / 2, kNafMinLength));
  return reflected_power(kNafShape, extended);
}

}  // namespace

RafMetrics raf_metrics(const ResponsePair& pair) {
  const int rate_hz = pair.reference.sample_rate_hz();
  if (rate_hz != 48000 && rate_hz != 16000) {
    throw InputError(kWhere, fmt::format("are at {} Hz, raf is defined at 48 and 16 kHz", rate_hz));
  }
  const StftShape shape = raf_shape(rate_hz);
  const std::ptrdiff_t samples = pair.reference.samples();
  if (samples <= shape.fft_size / 2) {
    throw InputError(kWhere,
                     fmt::format("have {} samples, raf needs {}", samples, shape.fft_size / 2 + 1));
  }
  RafMetrics metrics;
  for (int c = 0; c < pair.reference.channels(); ++c) {
    metrics.stft_error +=
        log_difference(reflected_power(shape, pair.reference.channel(c)),
                       reflected_power(shape, pair.estimate.channel(c)),
                       static_cast<int>(samples / shape.hop), shape.fft_size / 2 + 1) /
        pair.reference.channels();
  }
  const T60Error t60 = t60_error(pair, [&](Channel response) {
    return two_point_t60_s<float>(highpassed(response, rate_hz), 10.0, rate_hz);
  });
  metrics.t60_error_percent = t60.percent;
  metrics.t60_invalid = t60.invalid;
  metrics.edt_error_s =
      mean_difference(pair, [&](Channel response) { return early_decay_s(response, rate_hz); });
  metrics.c50_error_db = mean_difference(
      pair, [&](Channel response) { return std::optional<double>(clarity_db(response, rate_hz)); });
  return metrics;
}

NafMetrics naf_metrics(const ResponsePair& pair) {
  if (pair.reference.sample_rate_hz() != kNafRateHz) {
    throw InputError(kWhere, fmt::format("are at {} Hz, naf is defined at {} Hz",
                                         pair.reference.sample_rate_hz(), kNafRateHz));
  }
  const ResponsePair both{clamped(pair.reference), clamped(pair.estimate)};
  NafMetrics metrics;
  for (int c = 0; c < both.reference.channels(); ++c) {
    const PowerSpectrogram a = naf_spectrum(both.reference.channel(c));
    const PowerSpectrogram b = naf_spectrum(both.estimate.channel(c));
    metrics.spectral_loss += log_difference(a, b, a.frames, a.bins - 1) / both.reference.channels();
  }
  const T60Error t60 = t60_error(
      both, [](Channel response) { return two_point_t60_s<double>(response, 30.0, kNafRateHz); });
  metrics.t60_error_percent = t60.percent;
  metrics.t60_invalid = t60.invalid;
  return metrics;
}

}  // namespace earpoint
