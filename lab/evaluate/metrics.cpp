#include <earpoint/evaluate/metrics.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/envelope.h>
#include <earpoint/audio/gcc_phat.h>
#include <earpoint/audio/resample.h>
#include <earpoint/audio/stft.h>
#include <earpoint/core/ears.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr int kLongestDelayWindowS = 60;
constexpr StftShape kRwavsShape{512, 512, 128, Window::hann};

/// 10 log10(L / (R + 1e-5)), or nothing if the left ear is silent.
std::optional<double> left_right_ratio_db(const Waveform& wave) {
  const double left = energy(wave.channel(0));
  if (left == 0.0) return std::nullopt;
  return 10.0 * std::log10(left / (energy(wave.channel(1)) + 1e-5));
}

std::optional<double> left_right_error_db(const Waveform& reference, const Waveform& estimate) {
  const std::optional<double> a = left_right_ratio_db(reference);
  const std::optional<double> b = left_right_ratio_db(estimate);
  if (!a || !b) return std::nullopt;
  return std::abs(*a - *b);
}

double mean_squared_difference(std::span<const float> a, std::span<const float> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double difference = double{a[i]} - double{b[i]};
    sum += difference * difference;
  }
  return sum / static_cast<double>(a.size());
}

double magnitude(std::complex<float> value) {
  const double re = value.real();
  const double im = value.imag();
  return std::sqrt(re * re + im * im);
}

void check_one(const Waveform& wave, std::string_view name) {
  if (wave.channels() != kEars) {
    throw InputError(name, fmt::format("has {} channel{}, a binaural sound has 2 (left, right)",
                                       wave.channels(), wave.channels() == 1 ? "" : "s"));
  }
  if (wave.samples() == 0) throw InputError(name, "holds no samples");
  for (int c = 0; c < kEars; ++c) {
    const std::span<const float> channel = wave.channel(c);
    const auto bad = std::ranges::find_if(channel, [](float x) { return !std::isfinite(x); });
    if (bad != channel.end()) {
      throw InputError(name, fmt::format("sample {} of channel {} is not a finite number ({})",
                                         bad - channel.begin(), c, *bad));
    }
  }
}

}  // namespace

struct MetricEvaluator::State {
  /// Adds one ear's share to the metrics that compare short-time spectra.
  void compare_spectra(std::span<const float> reference, std::span<const float> estimate,
                       BinauralMetrics& metrics) {
    const Spectrogram a = stft.forward(reference);
    const Spectrogram b = stft.forward(estimate);
    double magnitudes = 0.0;
    double squares = 0.0;
    for (std::size_t i = 0; i < a.values.size(); ++i) {
      magnitudes += std::abs(magnitude(a.values[i]) - magnitude(b.values[i]));
      const double re = double{a.values[i].real()} - double{b.values[i].real()};
      const double im = double{a.values[i].imag()} - double{b.values[i].imag()};
      squares += re * re + im * im;
    }
    metrics.mag += magnitudes / static_cast<double>(a.values.size());
    metrics.stft_distance += std::sqrt(squares);
  }

  double delay(std::span<const float> reference, std::span<const float> estimate) {
    const auto samples = static_cast<int>(reference.size());
    if (!estimator || planned_samples != samples) {
      estimator.emplace(samples, samples);
      planned_samples = samples;
    }
    return std::min(std::abs(estimator->delay_samples(estimate, reference)), kMostDelaySamples);
  }

  double mean_delay(const Waveform& reference, const Waveform& estimate) {
    const std::ptrdiff_t longest =
        std::ptrdiff_t{kLongestDelayWindowS} * reference.sample_rate_hz();
    const std::ptrdiff_t parts = (reference.samples() + longest - 1) / longest;
    const std::ptrdiff_t length = reference.samples() / parts;
    double sum = 0.0;
    for (std::ptrdiff_t part = 0; part < parts; ++part) {
      for (int ear = 0; ear < kEars; ++ear) {
        sum += delay(reference.channel(ear).subspan(part * length, length),
                     estimate.channel(ear).subspan(part * length, length));
      }
    }
    return sum / static_cast<double>(kEars * parts);
  }

  Stft stft;
  std::optional<GccPhat> estimator;
  int planned_samples = 0;
};

MetricEvaluator::MetricEvaluator() : state_(std::make_unique<State>()) {}
MetricEvaluator::~MetricEvaluator() = default;
MetricEvaluator::MetricEvaluator(MetricEvaluator&&) noexcept = default;
MetricEvaluator& MetricEvaluator::operator=(MetricEvaluator&&) noexcept = default;

BinauralMetrics MetricEvaluator::measure(const Waveform& reference, const Waveform& estimate) {
  check_comparable(reference, "reference", estimate, "estimate");
  BinauralMetrics metrics;
  for (int ear = 0; ear < kEars; ++ear) {
    state_->compare_spectra(reference.channel(ear), estimate.channel(ear), metrics);
  }
  metrics.lre_db = left_right_error_db(reference, estimate);
  metrics.l2 = mean_squared_difference(reference.planar(), estimate.planar());
  metrics.delay_samples = state_->mean_delay(reference, estimate);
  return metrics;
}

BinauralMetrics binaural_metrics(const Waveform& reference, const Waveform& estimate) {
  return MetricEvaluator().measure(reference, estimate);
}

RwavsMetrics rwavs_metrics(const Waveform& reference, const Waveform& estimate) {
  check_comparable(reference, "reference", estimate, "estimate");
  const Waveform a = resample(reference, kRwavsRateHz);
  const Waveform b = resample(estimate, kRwavsRateHz);
  RwavsMetrics metrics;
  Stft stft(kRwavsShape);
  for (int ear = 0; ear < kEars; ++ear) {
    const Spectrogram s = stft.forward(a.channel(ear));
    const Spectrogram t = stft.forward(b.channel(ear));
    double sum = 0.0;
    for (std::size_t i = 0; i < s.values.size(); ++i) {
      const double difference = magnitude(s.values[i]) - magnitude(t.values[i]);
      sum += difference * difference;
    }
    metrics.mag += sum / static_cast<double>(s.values.size());

    const std::vector<double> p = hilbert_envelope(a.channel(ear));
    const std::vector<double> q = hilbert_envelope(b.channel(ear));
    double squares = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) squares += (p[i] - q[i]) * (p[i] - q[i]);
    metrics.env += std::sqrt(squares / static_cast<double>(p.size()));
  }
  return metrics;
}

SignFix fix_sign(std::span<Waveform> estimates, std::span<const Waveform> references) {
  EARPOINT_CHECK(estimates.size() == references.size());
  double between_ears = 0.0;
  double with_reference = 0.0;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    EARPOINT_CHECK(estimates[i].channels() == kEars && references[i].channels() == kEars);
    EARPOINT_CHECK(estimates[i].samples() == references[i].samples());
    const std::span<const float> left = std::as_const(estimates[i]).channel(0);
    const std::span<const float> right = std::as_const(estimates[i]).channel(1);
    const std::span<const float> reference = references[i].channel(0);
    for (std::size_t n = 0; n < left.size(); ++n) {
      between_ears += double{left[n]} * right[n];
      with_reference += double{left[n]} * reference[n];
    }
  }
  if (between_ears >= 0.0) return SignFix::none;
  const int ear = with_reference > 0.0 ? 1 : 0;
  for (Waveform& estimate : estimates) {
    for (float& x : estimate.channel(ear)) x = -x;
  }
  return ear == 1 ? SignFix::negated_right : SignFix::negated_left;
}

void check_comparable(const Waveform& reference, std::string_view reference_name,
                      const Waveform& estimate, std::string_view estimate_name) {
  check_one(reference, reference_name);
  check_one(estimate, estimate_name);
  if (reference.sample_rate_hz() != estimate.sample_rate_hz()) {
    throw InputError(estimate_name,
                     fmt::format("has {} Hz, {} has {} Hz", estimate.sample_rate_hz(),
                                 reference_name, reference.sample_rate_hz()),
                     "resample one of them");
  }
  if (reference.samples() != estimate.samples()) {
    throw InputError(estimate_name,
                     fmt::format("has {} samples, {} has {}", estimate.samples(), reference_name,
                                 reference.samples()),
                     "cut them to one length");
  }
}

}  // namespace earpoint
