#include "gates.h"
#include "measurement.h"
#include "references.h"
#include "rooms.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/core.h>

#include <earpoint/spatial/air_absorption.h>
#include <earpoint/trace/response_synthesizer.h>

namespace earpoint::gates {
namespace {

constexpr int kRate_hz = 16000;

// The largest magnitude, and its sample.
std::size_t peak_sample(std::span<const float> signal) {
  return static_cast<std::size_t>(std::distance(
      signal.begin(), std::max_element(signal.begin(), signal.end(), [](float a, float b) {
        return std::abs(a) < std::abs(b);
      })));
}

double total_energy(std::span<const float> signal) {
  return std::accumulate(signal.begin(), signal.end(), 0.0, [](double sum, float sample) {
    return sum + static_cast<double>(sample) * static_cast<double>(sample);
  });
}

// A band-limited signal between its samples.
double value_at(std::span<const float> signal, double position) {
  constexpr int kHalf = 200;
  const auto whole = static_cast<std::ptrdiff_t>(std::floor(position));
  double sum = 0.0;
  for (std::ptrdiff_t i = whole - kHalf; i <= whole + kHalf; ++i) {
    if (i < 0 || i >= std::ssize(signal)) continue;
    const double x = kPi * (position - static_cast<double>(i));
    sum += static_cast<double>(signal[i]) * (x == 0.0 ? 1.0 : std::sin(x) / x);
  }
  return sum;
}

Box gate_box(const Air& air) {
  return {.lengths_m = {6, 5, 3},
          .absorption = {0.4F, 0.4F, 0.35F, 0.3F, 0.25F, 0.25F, 0.28F, 0.3F},
          .air_db_per_m = air_absorption_db_per_m(air),
          .speed_m_per_s = speed_of_sound_m_per_s(air)};
}

// The largest difference of window energies in one octave band, where the reference is within 30 dB
// of its loudest window.
double largest_window_error_db(std::span<const float> found, std::span<const float> wanted,
                               double centre_hz) {
  constexpr int kWindow = kRate_hz / 100;
  const std::vector<double> a = window_energies(band_of(found, kRate_hz, centre_hz, 1.0), kWindow);
  const std::vector<double> b = window_energies(band_of(wanted, kRate_hz, centre_hz, 1.0), kWindow);
  const double loudest = *std::max_element(b.begin(), b.end());
  double largest_db = 0.0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    if (decibels(b[i] / loudest) < -30.0) continue;
    largest_db = std::max(largest_db, std::abs(decibels(a[i] / b[i])));
  }
  return largest_db;
}

}  // namespace

std::vector<GateRow> free_field_gate(ThreadPool& pool) {
  const AcousticScene scene(open_air());
  const std::vector<Vector3> listeners = {
      {1, 0, 0}, {0, 2, 0}, {0, 0, 4}, {4.8, 6.4, 0}, {-16, 0, 0}};
  const Source source = omni({0, 0, 0});
  const TraceOptions options{.rays = 1000, .air_absorbs = false};
  const TraceResult result = trace(scene, {&source, 1}, listeners, options, pool);
  const ResponseSynthesizer synthesizer({.sample_rate_hz = kRate_hz});
  double worst_db = 0.0;
  double worst_samples = 0.0;
  double previous = 0.0;
  for (std::size_t i = 0; i < listeners.size(); ++i) {
    const Waveform response = synthesizer.mono(result.responses[0][i], i);
    const double energy = total_energy(response.channel(0));
    if (i > 0) worst_db = std::max(worst_db, std::abs(decibels(previous / energy) - 6.0206));
    previous = energy;
    const double expected = norm(listeners[i]) / speed_of_sound_m_per_s(options.air) * kRate_hz;
    const auto found = static_cast<double>(peak_sample(response.channel(0)));
    worst_samples = std::max(worst_samples, std::abs(found - expected));
  }
  // Exact but for single precision; 0.1 dB is inaudible. A peak is at the nearest sample.
  return {{.gate = "free field, 1 to 16 m: level per doubling of distance",
           .measured = fmt::format("6.02 dB within {:.4f} dB", worst_db),
           .limit = "0.1 dB",
           .passed = worst_db < 0.1},
          {.gate = "free field: sample of the first arrival",
           .measured = fmt::format("within {:.2f} samples", worst_samples),
           .limit = "1 sample",
           .passed = worst_samples <= 1.0}};
}

std::vector<GateRow> image_source_gate(ThreadPool& pool) {
  const TraceOptions options{.mirror_rays = 120'000, .duration_s = 0.4};
  const Box box = gate_box(options.air);
  const Vector3 source{1.9, 2.1, 1.6};
  const Vector3 listener{4.1, 3.2, 1.2};
  const std::vector<BoxImage> images =
      box_images(box, source, listener, options.duration_s * box.speed_m_per_s);
  const int samples = static_cast<int>(options.duration_s * kRate_hz);
  const std::vector<float> wanted = image_response(box, images, kRate_hz, samples);

  const AcousticScene scene(make_shoebox(box.lengths_m, box.absorption, all_bands(0.0F)));
  const Source from = omni(source);
  const TraceResult result = trace(scene, {&from, 1}, {&listener, 1}, options, pool);
  const ResponseSynthesizer synthesizer(
      {.sample_rate_hz = kRate_hz, .duration_s = options.duration_s});
  const Waveform response = synthesizer.mono(result.responses[0][0], 0);
  const std::span<const float> found = response.channel(0);

  // The same arrivals are summed twice: exact but for single precision. The limits are far below 1
  // dB, which is just audible.
  std::vector<GateRow> rows;
  for (int band = 0; band < kOctaveBands; ++band) {
    const double centre_hz = kOctaveBandCentresHz[band];
    const double error_db = largest_window_error_db(found, wanted, centre_hz);
    rows.push_back(
        {.gate = fmt::format("specular box against image sources, {:g} Hz: energy per 10 ms, down "
                             "to -30 dB",
                             centre_hz),
         .measured = fmt::format("within {:.3f} dB", error_db),
         .limit = "0.3 dB",
         .passed = error_db < 0.3});
  }
  double worst_db = 0.0;
  int count = 0;
  for (const BoxImage& image : images) {
    if (image.reflections < 1 || image.reflections > 3) continue;
    const double position = image.distance_m / box.speed_m_per_s * kRate_hz;
    const double ratio = value_at(found, position) / value_at(wanted, position);
    worst_db = std::max(worst_db, std::abs(20.0 * std::log10(std::abs(ratio))));
    ++count;
  }
  rows.push_back({.gate = fmt::format("the same: level at the exact times of the {} arrivals of "
                                      "order 1 to 3",
                                      count),
                  .measured = fmt::format("within {:.3f} dB", worst_db),
                  .limit = "0.5 dB",
                  .passed = worst_db < 0.5});
  return rows;
}

}  // namespace earpoint::gates
