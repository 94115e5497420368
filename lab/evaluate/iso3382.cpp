#include <earpoint/evaluate/iso3382.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include <earpoint/audio/butterworth.h>
#include <earpoint/audio/decay.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr const char* kWhere = "impulse responses";

using Sections = std::vector<SecondOrderSection>;
using Channel = std::span<const float>;

constexpr std::array kCentresHz{125.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0};
constexpr int kOrder = 3;
constexpr std::array kSingleNumberHz{500.0, 1000.0};
// Silence before the response that the filter, run backwards, rings into: -60 dB of the 125 Hz
// octave after 0.06 s.
constexpr double kRingingS = 0.25;

/// The response backwards through the filter: [ringing + samples].
std::vector<double> filtered(const Sections& sections, Channel response, std::ptrdiff_t ringing) {
  SectionFilter filter(sections);
  std::vector<double> out(response.size() + static_cast<std::size_t>(ringing));
  for (std::size_t i = out.size(); i-- > 0;) {
    const bool before = i < static_cast<std::size_t>(ringing);
    out[i] = filter.process(before ? 0.0 : double{response[i - ringing]});
  }
  return out;
}

double energy_of(const std::vector<double>& signal) {
  double sum = 0.0;
  for (const double x : signal) sum += x * x;
  return sum;
}

std::size_t direct_sound(Channel response) {
  float largest = 0.0F;
  for (const float x : response) {
    if (!std::isfinite(x)) throw InputError(kWhere, "hold NaN or infinite samples");
    largest = std::max(largest, std::abs(x));
  }
  if (largest == 0.0F) throw InputError(kWhere, "a channel is silent");
  const float threshold = 0.1F * largest;
  const auto first =
      std::ranges::find_if(response, [threshold](float x) { return std::abs(x) >= threshold; });
  return static_cast<std::size_t>(first - response.begin());
}

/// Early and late energy of a band.
struct Shares {
  double early = 0.0;
  double late = 0.0;
};

Shares shares_of(const Sections& sections, Channel response, std::size_t direct, double split_s,
                 int rate_hz) {
  const auto split =
      std::min(response.size(), direct + static_cast<std::size_t>(std::lround(split_s * rate_hz)));
  const auto ringing = static_cast<std::ptrdiff_t>(kRingingS * rate_hz);
  const Shares shares{
      energy_of(filtered(sections, response.subspan(direct, split - direct), ringing)),
      energy_of(filtered(sections, response.subspan(split), ringing))};
  if (shares.late <= 0.0) {
    throw InputError(kWhere, fmt::format("nothing follows the first {:.0f} ms", 1000.0 * split_s));
  }
  return shares;
}

/// The centre of gravity of a squared signal, in samples after `origin`.
double centre_samples(const std::vector<double>& signal, std::ptrdiff_t origin) {
  double energy = 0.0;
  double moment = 0.0;
  for (std::size_t i = 0; i < signal.size(); ++i) {
    const double square = signal[i] * signal[i];
    energy += square;
    moment += square * static_cast<double>(static_cast<std::ptrdiff_t>(i) - origin);
  }
  return moment / energy;
}

/// Of the band after the direct sound; the time by which the filter itself is early is taken out.
double centre_time_s(const Sections& sections, const std::vector<double>& band,
                     std::ptrdiff_t direct, std::ptrdiff_t ringing, int rate_hz) {
  const std::vector<float> impulse{1.0F};
  const double early = centre_samples(filtered(sections, impulse, ringing), ringing);
  return (centre_samples(band, ringing + direct) - early) / rate_hz;
}

std::optional<double> decay_time_s(Channel band, int rate_hz, double (*measure)(Channel, double)) {
  try {
    return measure(band, rate_hz);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

IsoBand band_of(Channel response, std::size_t direct, double centre_hz, int rate_hz) {
  const double half = std::sqrt(2.0);
  const Sections sections =
      butterworth_bandpass(centre_hz / half, centre_hz * half, rate_hz, kOrder);
  const auto ringing = static_cast<std::ptrdiff_t>(kRingingS * rate_hz);
  const std::vector<double> band = filtered(sections, response, ringing);
  const std::vector<float> rounded(band.begin(), band.end());
  const Shares at_50 = shares_of(sections, response, direct, 0.05, rate_hz);
  const Shares at_80 = shares_of(sections, response, direct, 0.08, rate_hz);
  return {
      .centre_hz = centre_hz,
      .edt_s = decay_time_s(rounded, rate_hz, early_decay_time_s),
      .t20_s = decay_time_s(rounded, rate_hz, reverberation_time_t20_s),
      .t30_s = decay_time_s(rounded, rate_hz, reverberation_time_t30_s),
      .c50_db = 10.0 * std::log10(at_50.early / at_50.late),
      .c80_db = 10.0 * std::log10(at_80.early / at_80.late),
      .d50 = at_50.early / (at_50.early + at_50.late),
      .ts_s = centre_time_s(sections, band, static_cast<std::ptrdiff_t>(direct), ringing, rate_hz)};
}

/// The mean of a parameter over the bands of 500 Hz and 1 kHz.
template <typename Parameter>
std::optional<double> single_number(const std::vector<IsoBand>& bands, Parameter parameter) {
  double sum = 0.0;
  for (const double centre_hz : kSingleNumberHz) {
    const auto band = std::ranges::find(bands, centre_hz, &IsoBand::centre_hz);
    if (band == bands.end()) {
      throw InputError(
          kWhere,
          fmt::format("their sample rate is too low for the octave at {:.0f} Hz", centre_hz));
    }
    const std::optional<double> value = (*band).*parameter;
    if (!value) return std::nullopt;
    sum += *value;
  }
  return sum / kSingleNumberHz.size();
}

/// @param relative  percent of the reference's value
template <typename Parameter>
std::optional<double> mean_error(const IsoMetrics& metrics, Parameter parameter, bool relative) {
  double sum = 0.0;
  for (std::size_t c = 0; c < metrics.reference.size(); ++c) {
    const std::optional<double> a = single_number(metrics.reference[c], parameter);
    const std::optional<double> b = single_number(metrics.estimate[c], parameter);
    if (!a || !b) return std::nullopt;
    sum += std::abs(*a - *b) * (relative ? 100.0 / *a : 1.0);
  }
  return sum / static_cast<double>(metrics.reference.size());
}

}  // namespace

std::vector<IsoBand> iso_bands(std::span<const float> response, int sample_rate_hz) {
  const std::size_t direct = direct_sound(response);
  std::vector<IsoBand> bands;
  for (const double centre_hz : kCentresHz) {
    if (centre_hz * std::sqrt(2.0) >= sample_rate_hz / 2.0) break;
    bands.push_back(band_of(response, direct, centre_hz, sample_rate_hz));
  }
  return bands;
}

IsoMetrics iso_metrics(const ResponsePair& pair) {
  IsoMetrics metrics;
  const int rate_hz = pair.reference.sample_rate_hz();
  for (int c = 0; c < pair.reference.channels(); ++c) {
    metrics.reference.push_back(iso_bands(pair.reference.channel(c), rate_hz));
    metrics.estimate.push_back(iso_bands(pair.estimate.channel(c), rate_hz));
  }
  metrics.edt_error_percent = mean_error(metrics, &IsoBand::edt_s, true);
  metrics.t20_error_percent = mean_error(metrics, &IsoBand::t20_s, true);
  metrics.t30_error_percent = mean_error(metrics, &IsoBand::t30_s, true);
  metrics.c50_error_db = mean_error(metrics, &IsoBand::c50_db, false).value();
  metrics.c80_error_db = mean_error(metrics, &IsoBand::c80_db, false).value();
  metrics.d50_error = mean_error(metrics, &IsoBand::d50, false).value();
  metrics.ts_error_ms = 1000.0 * mean_error(metrics, &IsoBand::ts_s, false).value();
  return metrics;
}

}  // namespace earpoint
