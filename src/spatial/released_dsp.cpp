#include <earpoint/spatial/released_dsp.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdlib>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kRegularisation = 1e-4;

std::vector<std::array<double, 2>> angles_deg(const SofaFile& file) {
  std::vector<std::array<double, 2>> angles;
  // Angles went through float32 and cartesian coordinates: 15 degrees must not become 14.
  constexpr double kRounding = 1e-4;
  for (const Vector3& position_m : file.positions_m) {
    const Spherical s = spherical_from_cartesian(position_m);
    double azimuth_deg = degrees_from_radians(s.azimuth_rad) + kRounding;
    if (azimuth_deg < 0.0) azimuth_deg += 360.0;
    const double elevation_deg = degrees_from_radians(s.elevation_rad);
    angles.push_back({azimuth_deg, elevation_deg + std::copysign(kRounding, elevation_deg)});
  }
  return angles;
}

// The listed value nearest to a wanted one, the smaller of two that are equally near.
int nearest_listed(const std::vector<std::array<int, 2>>& listed, int column, double wanted) {
  int best = listed.front()[column];
  for (const std::array<int, 2>& row : listed) {
    const double gain = std::abs(best - wanted) - std::abs(row[column] - wanted);
    if (gain > 0.0 || (gain == 0.0 && row[column] < best)) best = row[column];
  }
  return best;
}

// Adds gain * (response convolved with x, one sample late, cut after x's length plus one).
void add_convolved(std::span<const double> response, std::span<const float> x, double gain,
                   std::span<double> out) {
  const auto taps = std::ssize(response);
  for (std::ptrdiff_t t = 1; t < std::ssize(out); ++t) {
    double sum = 0.0;
    for (std::ptrdiff_t k = 0; k < std::min(taps, t); ++k) sum += response[k] * x[t - 1 - k];
    out[t] += gain * sum;
  }
}

// The inverse DFT of conj(H) / (|H|^2 + regularisation). Direct sums: the responses have a few
// hundred samples, so that is cheap.
std::vector<double> circular_inverse(std::span<const float> response) {
  const auto length = std::ssize(response);
  std::vector<std::complex<double>> turns(length);
  for (std::ptrdiff_t n = 0; n < length; ++n) {
    turns[n] = std::polar(1.0, 2.0 * kPi * static_cast<double>(n) / static_cast<double>(length));
  }
  std::vector<std::complex<double>> spectrum(length);
  for (std::ptrdiff_t k = 0; k < length; ++k) {
    std::complex<double> h = 0.0;
    for (std::ptrdiff_t n = 0; n < length; ++n) {
      h += static_cast<double>(response[n]) * std::conj(turns[k * n % length]);
    }
    spectrum[k] = std::conj(h) / (std::norm(h) + kRegularisation);
  }
  std::vector<double> inverse(length);
  for (std::ptrdiff_t n = 0; n < length; ++n) {
    double sum = 0.0;
    for (std::ptrdiff_t k = 0; k < length; ++k) {
      sum += (spectrum[k] * turns[k * n % length]).real();
    }
    inverse[n] = sum / static_cast<double>(length);
  }
  return inverse;
}

}  // namespace

ReleasedDsp::ReleasedDsp(std::span<const std::array<double, 2>> azimuth_elevation_deg,
                         std::span<const float> responses, int taps)
    : responses_(responses.begin(), responses.end()), taps_(taps) {
  EARPOINT_CHECK(!azimuth_elevation_deg.empty() && taps > 0);
  EARPOINT_CHECK(responses.size() == azimuth_elevation_deg.size() * 2 * taps);
  for (const auto& [azimuth_deg, elevation_deg] : azimuth_elevation_deg) {
    positions_deg_.push_back({static_cast<int>(azimuth_deg), static_cast<int>(elevation_deg)});
  }
}

ReleasedDsp::ReleasedDsp(const SofaFile& file)
    : ReleasedDsp(angles_deg(file), file.responses, file.taps) {}

double ReleasedDsp::gain(double distance_m) { return 0.2 / std::max(0.2, distance_m); }

std::size_t ReleasedDsp::measurement(const Position& position) const {
  const std::array<int, 2> wanted = {nearest_listed(positions_deg_, 0, position.azimuth_deg),
                                     nearest_listed(positions_deg_, 1, position.elevation_deg)};
  const auto found = std::find(positions_deg_.begin(), positions_deg_.end(), wanted);
  if (found == positions_deg_.end()) {
    throw InputError(
        "released DSP baseline",
        fmt::format("no response at azimuth {} and elevation {} degrees", wanted[0], wanted[1]),
        "it looks up one angle at a time, which needs a full grid; use elevation 0");
  }
  return static_cast<std::size_t>(found - positions_deg_.begin());
}

std::span<const float> ReleasedDsp::response(std::size_t measurement, int ear) const {
  return std::span(responses_).subspan((measurement * 2 + ear) * taps_, taps_);
}

Waveform ReleasedDsp::apply(std::span<const float> mono, const Position& position,
                            int sample_rate_hz) const {
  const std::size_t index = measurement(position);
  Waveform binaural(2, std::ssize(mono) + 1, sample_rate_hz);
  for (int ear = 0; ear < 2; ++ear) {
    const std::span<const float> taps = response(index, ear);
    const std::vector<double> filter(taps.begin(), taps.end());
    std::vector<double> sum(binaural.samples(), 0.0);
    add_convolved(filter, mono, gain(position.distance_m), sum);
    std::transform(sum.begin(), sum.end(), binaural.channel(ear).begin(),
                   [](double value) { return static_cast<float>(value); });
  }
  return binaural;
}

std::vector<float> ReleasedDsp::apply_inverse(const Waveform& binaural,
                                              const Position& position) const {
  EARPOINT_CHECK(binaural.channels() == 2);
  const std::size_t index = measurement(position);
  std::vector<double> sum(binaural.samples() + 1, 0.0);
  for (int ear = 0; ear < 2; ++ear) {
    add_convolved(circular_inverse(response(index, ear)), binaural.channel(ear),
                  0.5 / gain(position.distance_m), sum);
  }
  std::vector<float> mono(sum.size());
  std::transform(sum.begin(), sum.end(), mono.begin(),
                 [](double value) { return static_cast<float>(value); });
  return mono;
}

}  // namespace earpoint
