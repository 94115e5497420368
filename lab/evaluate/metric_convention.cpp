#include <earpoint/evaluate/metric_convention.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include <fmt/format.h>

#include <earpoint/audio/energy.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kMinDecayDb = 3.0;
constexpr std::array kNames{
    std::pair{"paper", MetricConvention::paper}, std::pair{"rwavs", MetricConvention::rwavs},
    std::pair{"raf", MetricConvention::raf},     std::pair{"naf", MetricConvention::naf},
    std::pair{"avr", MetricConvention::avr},     std::pair{"iso", MetricConvention::iso}};

void check_samples(const Waveform& wave, std::string_view name) {
  if (wave.channels() == 0 || wave.samples() == 0) throw InputError(name, "holds no samples");
  for (int c = 0; c < wave.channels(); ++c) {
    if (!std::ranges::all_of(wave.channel(c), [](float x) { return std::isfinite(x); })) {
      throw InputError(name, fmt::format("channel {} holds NaN or infinite samples", c));
    }
  }
}

/// The first `samples`; zeros after the end.
Waveform of_length(const Waveform& wave, std::ptrdiff_t samples) {
  Waveform result(wave.channels(), samples, wave.sample_rate_hz());
  const auto kept = static_cast<std::size_t>(std::min(samples, wave.samples()));
  for (int c = 0; c < wave.channels(); ++c) {
    std::ranges::copy(wave.channel(c).first(kept), result.channel(c).begin());
  }
  return result;
}

}  // namespace

MetricConvention convention_named(std::string_view name) {
  for (const auto& [known, convention] : kNames) {
    if (name == known) return convention;
  }
  throw InputError("convention",
                   fmt::format("expected paper, rwavs, raf, naf, avr or iso, found {}", name));
}

bool compares_responses(MetricConvention convention) {
  return convention != MetricConvention::paper && convention != MetricConvention::rwavs;
}

std::optional<double> compared_length_s(MetricConvention convention) {
  if (convention == MetricConvention::raf) return 0.32;
  if (convention == MetricConvention::avr) return 0.1;
  return std::nullopt;
}

int convention_rate_hz(MetricConvention convention, int file_rate_hz) {
  if (convention == MetricConvention::naf) return 22050;
  if (convention == MetricConvention::raf && file_rate_hz != 16000) return 48000;
  return file_rate_hz;
}

void check_decays(const Waveform& sound, std::string_view name) {
  for (int c = 0; c < sound.channels(); ++c) {
    const std::span<const float> all = sound.channel(c);
    if (energy(all) == 0.0) throw InputError(name, fmt::format("channel {} is silent", c));
    const auto loudest =
        std::ranges::max_element(all, {}, [](float x) { return std::abs(x); }) - all.begin();
    const std::span<const float> decay = all.subspan(static_cast<std::size_t>(loudest));
    const std::size_t quarter = decay.size() / 4;
    const double first = energy(decay.first(quarter));
    const double last = energy(decay.last(quarter));
    if (first > 0.0 && last <= first * std::pow(10.0, -kMinDecayDb / 10.0)) continue;
    throw InputError(
        name,
        fmt::format("channel {} is not an impulse response: it does not decay after its loudest "
                    "sample",
                    c));
  }
}

ResponsePair response_pair(Waveform reference, std::string_view reference_name, Waveform estimate,
                           std::string_view estimate_name, std::optional<double> length_s) {
  check_samples(reference, reference_name);
  check_samples(estimate, estimate_name);
  if (reference.channels() != estimate.channels()) {
    throw InputError(estimate_name, fmt::format("has {} channels, {} has {}", estimate.channels(),
                                                reference_name, reference.channels()));
  }
  if (reference.sample_rate_hz() != estimate.sample_rate_hz()) {
    throw InputError(estimate_name,
                     fmt::format("has {} Hz, {} has {} Hz", estimate.sample_rate_hz(),
                                 reference_name, reference.sample_rate_hz()),
                     "resample one of them");
  }
  check_decays(reference, reference_name);
  std::ptrdiff_t samples = std::max(reference.samples(), estimate.samples());
  if (length_s) {
    EARPOINT_CHECK(*length_s > 0.0);
    samples = std::min(
        samples, static_cast<std::ptrdiff_t>(std::lround(*length_s * reference.sample_rate_hz())));
  }
  if (reference.samples() != samples) reference = of_length(reference, samples);
  if (estimate.samples() != samples) estimate = of_length(estimate, samples);
  return {std::move(reference), std::move(estimate)};
}

}  // namespace earpoint
