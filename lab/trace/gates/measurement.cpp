#include "measurement.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>

#include <earpoint/audio/fft.h>
#include <earpoint/pose.h>

namespace earpoint::gates {
double band_weight(double octaves_away, double half_width) {
  constexpr double kFlank = 0.5;  // wide enough that the filter rings less than rooms decay
  const double into_flank = (std::abs(octaves_away) - (half_width - kFlank / 2.0)) / kFlank;
  if (into_flank <= 0.0) return 1.0;
  if (into_flank >= 1.0) return 0.0;
  return 0.5 + 0.5 * std::cos(kPi * into_flank);
}

std::vector<double> band_of(std::span<const float> response, int sample_rate_hz, double centre_hz,
                            double octaves) {
  // Zero-padded to twice the length, for the filter's ringing.
  const int size = fast_fft_size(2 * static_cast<int>(response.size()));
  RealFft<double> fft(size);
  std::vector<double> signal(size);
  std::copy(response.begin(), response.end(), signal.begin());
  std::vector<std::complex<double>> spectrum(fft.bins());
  fft.forward(signal, spectrum);
  for (int bin = 0; bin < fft.bins(); ++bin) {
    const double frequency_hz = static_cast<double>(bin) * sample_rate_hz / size;
    const double away = frequency_hz > 0.0 ? std::abs(std::log2(frequency_hz / centre_hz)) : 1e9;
    spectrum[bin] *= band_weight(away, octaves / 2.0);
  }
  fft.inverse(spectrum, signal);
  signal.resize(response.size());
  return signal;
}

std::vector<double> window_energies(std::span<const double> signal, int window_samples) {
  std::vector<double> energies(signal.size() / window_samples);
  for (std::size_t i = 0; i < energies.size(); ++i) {
    energies[i] = energy(signal.subspan(i * window_samples, window_samples));
  }
  return energies;
}

std::vector<double> backward_energy(std::span<const double> signal) {
  std::vector<double> backward(signal.size());
  double sum = 0.0;
  for (std::size_t i = signal.size(); i-- > 0;) {
    sum += signal[i] * signal[i];
    backward[i] = sum;
  }
  return backward;
}

double decay_time_s(std::span<const double> backward, double steps_per_s, double from_db,
                    double to_db) {
  double n = 0.0;
  double sum_t = 0.0;
  double sum_l = 0.0;
  double sum_tt = 0.0;
  double sum_tl = 0.0;
  bool reached = false;
  for (std::size_t i = 0; i < backward.size() && !reached; ++i) {
    const double level_db = decibels(backward[i] / backward[0]);
    reached = level_db < to_db;
    if (level_db > from_db || reached) continue;
    const double t = static_cast<double>(i) / steps_per_s;
    n += 1.0;
    sum_t += t;
    sum_l += level_db;
    sum_tt += t * t;
    sum_tl += t * level_db;
  }
  if (!reached || n < 2.0) throw std::runtime_error("the decay does not go down far enough");
  return -60.0 * (n * sum_tt - sum_t * sum_t) / (n * sum_tl - sum_t * sum_l);
}

double arrivals_level_db(const PointResponse& response, int band, double speed_m_per_s) {
  constexpr int kFrequencies = 9;
  double sum = 0.0;
  double weights = 0.0;
  for (int i = 0; i < kFrequencies; ++i) {
    const double frequency_hz =
        kOctaveBandCentresHz[band] * std::exp2((i + 0.5) / kFrequencies - 0.5);
    const double wave_number = 2.0 * kPi * frequency_hz / speed_m_per_s;
    std::complex<double> pressure = 0.0;
    for (const Arrival& arrival : response.arrivals) {
      pressure += static_cast<double>(arrival.gain[band]) *
                  std::polar(1.0, -wave_number * arrival.delay_s * speed_m_per_s);
    }
    // White sound has its energy even over frequency, not over octaves.
    sum += frequency_hz * std::norm(pressure);
    weights += frequency_hz;
  }
  return decibels(sum / weights);
}

double energy(std::span<const double> signal) {
  double sum = 0.0;
  for (const double sample : signal) sum += sample * sample;
  return sum;
}

double decibels(double energy_ratio) { return 10.0 * std::log10(energy_ratio); }

}  // namespace earpoint::gates
