#include <earpoint/evaluate/metric_convention.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <earpoint/audio/energy.h>
#include <earpoint/audio/window_of.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kMinDecayDb = 3.0;
// In the order of MetricConvention.
constexpr std::array<std::string_view, 6> kNames{"paper", "rwavs", "raf", "naf", "avr", "iso"};
static_assert(kNames.size() == static_cast<std::size_t>(MetricConvention::iso) + 1);

void check_samples(const Waveform& wave, std::string_view name) {
  if (wave.channels() == 0 || wave.samples() == 0) throw InputError(name, "holds no samples");
  for (int c = 0; c < wave.channels(); ++c) {
    if (!std::ranges::all_of(wave.channel(c), [](float x) { return std::isfinite(x); })) {
      throw InputError(name, fmt::format("channel {} holds NaN or infinite samples", c));
    }
  }
}

}  // namespace

std::vector<std::string> convention_names() { return {kNames.begin(), kNames.end()}; }

std::vector<std::string> response_convention_names() {
  std::vector<std::string> names = convention_names();
  std::erase_if(
      names, [](const std::string& name) { return !compares_responses(convention_named(name)); });
  return names;
}

MetricConvention convention_named(std::string_view name) {
  const auto found = std::ranges::find(kNames, name);
  if (found != kNames.end()) return static_cast<MetricConvention>(found - kNames.begin());
  throw InputError("convention", fmt::format("expected {} or {}, found {}",
                                             fmt::join(kNames.begin(), kNames.end() - 1, ", "),
                                             kNames.back(), name));
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
  if (reference.samples() != samples) reference = window_of(reference, 0, samples);
  if (estimate.samples() != samples) estimate = window_of(estimate, 0, samples);
  return {std::move(reference), std::move(estimate)};
}

}  // namespace earpoint
