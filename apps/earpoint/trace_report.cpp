#include "trace_report.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include <fmt/format.h>

#include <earpoint/audio/decay.h>
#include <earpoint/audio/fft.h>
#include <earpoint/error.h>
#include <earpoint/spatial/octave_bands.h>

namespace earpoint {
namespace {

std::vector<float> octave_of(std::span<const float> response, int sample_rate_hz, int band) {
  const int ringing = octave_bank_half_length(sample_rate_hz);
  RealFft<float> fft(fast_fft_size(static_cast<int>(response.size()) + 2 * ringing));
  const OctaveBank bank(sample_rate_hz, fft.size());
  std::vector<float> signal(fft.size());
  std::ranges::copy(response, signal.begin());
  std::vector<std::complex<float>> spectrum(fft.bins());
  fft.forward(signal, spectrum);
  for (int bin = 0; bin < fft.bins(); ++bin) spectrum[bin] *= bank.weights(band)[bin];
  fft.inverse(spectrum, signal);
  signal.resize(response.size());
  return signal;
}

/// A measure, or a dash if the response does not have it: a decay that ends too early, silence.
template <typename Measure>
std::string text_of(Measure measure, const char* format) {
  try {
    return fmt::format(fmt::runtime(format), measure());
  } catch (const InputError&) {
    return "-";
  }
}

}  // namespace

std::string trace_report(const TraceResult& traced, std::span<const float> mono, int sample_rate_hz,
                         double seconds) {
  const PointResponse& response = traced.responses[0][0];
  std::string text = fmt::format("{:>8} {:>8} {:>8} {:>8} {:>10}\n", "band Hz", "T30 s", "EDT s",
                                 "C50 dB", "direct dB");
  for (int band = 0; band < kOctaveBands; ++band) {
    const double centre_hz = kOctaveBandCentresHz[band];
    if (centre_hz > sample_rate_hz / 2.0) break;
    const std::vector<float> octave = octave_of(mono, sample_rate_hz, band);
    const auto measure = [&](auto function) {
      return [&, function] { return function(octave, sample_rate_hz); };
    };
    text += fmt::format(
        "{:>8g} {:>8} {:>8} {:>8} {:>10}\n", centre_hz,
        text_of(measure(reverberation_time_t30_s), "{:.2f}"),
        text_of(measure(early_decay_time_s), "{:.2f}"), text_of(measure(clarity_c50_db), "{:.1f}"),
        response.sees_source
            ? fmt::format("{:.1f}", 20.0 * std::log10(response.arrivals[0].gain[band]))
            : "none");
  }
  text += fmt::format(
      "distance {:.3f} m, first arrival {}, {} sharp arrivals\n", response.distance_m,
      response.arrivals.empty() ? "none"
                                : fmt::format("{:.3f} ms", 1e3 * response.arrivals[0].delay_s),
      response.arrivals.size());
  text += fmt::format("escape fraction {:.2g}, {} rays, {:.3f} s\n", traced.escape_fraction[0],
                      traced.rays_cast, seconds);
  return text;
}

}  // namespace earpoint
