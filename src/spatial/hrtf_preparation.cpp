#include "hrtf_preparation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numeric>

#include <earpoint/audio/fft.h>
#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

using Complex = std::complex<double>;

double largest_delay(const SofaFile& file) {
  double largest = 0.0;
  for (const auto& delays : file.delays_samples) {
    largest = std::max({largest, delays[0], delays[1]});
  }
  return largest;
}

// Delays by a fraction of samples with a phase ramp, which is exact below Nyquist.
void delay_response(std::span<const float> in, double delay_samples, RealFft<double>& fft,
                    std::span<float> out) {
  std::vector<double> padded(fft.size(), 0.0);
  std::vector<Complex> spectrum(fft.bins());
  std::copy(in.begin(), in.end(), padded.begin());
  fft.forward(padded, spectrum);
  for (int bin = 0; bin < fft.bins(); ++bin) {
    spectrum[bin] *= std::polar(1.0, -2.0 * kPi * bin * delay_samples / fft.size());
  }
  fft.inverse(spectrum, padded);
  std::transform(padded.begin(), padded.begin() + std::ssize(out), out.begin(),
                 [](double value) { return static_cast<float>(value); });
}

// The share of the sphere that is nearest to each direction; sums to one.
std::vector<double> sphere_shares(std::span<const Vector3> directions) {
  // An even spread of points by the golden angle, each given to the direction nearest to it.
  constexpr int kPoints = 4000;
  const double golden = kPi * (3.0 - std::sqrt(5.0));
  std::vector<double> shares(directions.size(), 0.0);
  for (int i = 0; i < kPoints; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kPoints;
    const double radius = std::sqrt(1.0 - z * z);
    const Vector3 point{radius * std::cos(golden * i), radius * std::sin(golden * i), z};
    const auto nearest = std::ranges::max_element(
        directions, {}, [&](const Vector3& direction) { return dot(direction, point); });
    shares[nearest - directions.begin()] += 1.0 / kPoints;
  }
  return shares;
}

// Power average over directions and ears, on the bins of `fft`. A power spectrum is known from its
// autocorrelation, which is as long as the response: all but the last transform can be short.
std::vector<double> mean_power(HrtfResponses& set, RealFft<double>& fft) {
  RealFft<double> shorter(fast_fft_size(2 * set.taps));
  std::vector<double> padded(shorter.size(), 0.0);
  std::vector<Complex> spectrum(shorter.bins());
  std::vector<Complex> power(shorter.bins(), 0.0);
  for (std::size_t i = 0; i < set.directions.size(); ++i) {
    for (int ear = 0; ear < 2; ++ear) {
      std::ranges::copy(set.response(i, ear), padded.begin());
      shorter.forward(padded, spectrum);
      for (int bin = 0; bin < shorter.bins(); ++bin) {
        power[bin] += 0.5 * set.shares[i] * std::norm(spectrum[bin]);
      }
    }
  }
  shorter.inverse(power, padded);
  std::vector<double> autocorrelation(fft.size(), 0.0);
  for (int lag = 0; lag < set.taps; ++lag) {
    autocorrelation[lag] = padded[lag];
    if (lag > 0) autocorrelation[fft.size() - lag] = padded[lag];
  }
  std::vector<Complex> whole(fft.bins());
  fft.forward(autocorrelation, whole);
  std::vector<double> result(fft.bins());
  std::ranges::transform(whole, result.begin(),
                         [](const Complex& value) { return std::max(0.0, value.real()); });
  return result;
}

// The same, third-octave smoothed, as dB per bin.
std::vector<double> diffuse_field_db(HrtfResponses& set, RealFft<double>& fft) {
  const std::vector<double> power = mean_power(set, fft);
  std::vector<double> running(fft.bins() + 1, 0.0);
  std::partial_sum(power.begin(), power.end(), running.begin() + 1);
  std::vector<double> level_db(fft.bins());
  const double sixth = std::exp2(1.0 / 6.0);
  for (int bin = 0; bin < fft.bins(); ++bin) {
    const int low = static_cast<int>(bin / sixth);
    const int high = std::min(static_cast<int>(std::ceil(bin * sixth)) + 1, fft.bins());
    level_db[bin] = 10.0 * std::log10((running[high] - running[low]) / (high - low) + 1e-30);
  }
  return level_db;
}

// The minimum-phase spectrum of a magnitude in nepers, by folding its cepstrum.
std::vector<Complex> minimum_phase(std::span<const double> log_magnitude, RealFft<double>& fft) {
  std::vector<Complex> spectrum(log_magnitude.begin(), log_magnitude.end());
  std::vector<double> cepstrum(fft.size());
  fft.inverse(spectrum, cepstrum);
  const int half = fft.size() / 2;
  std::transform(cepstrum.begin() + 1, cepstrum.begin() + half, cepstrum.begin() + 1,
                 [](double value) { return 2.0 * value; });
  std::fill(cepstrum.begin() + half + 1, cepstrum.end(), 0.0);
  fft.forward(cepstrum, spectrum);
  for (Complex& value : spectrum) value = std::exp(value);
  return spectrum;
}

// Written out because std::complex's product checks for infinities.
void multiply(std::span<const std::complex<float>> factor,
              std::span<std::complex<float>> spectrum) {
  for (std::size_t bin = 0; bin < spectrum.size(); ++bin) {
    const std::complex<float> a = spectrum[bin];
    const std::complex<float> b = factor[bin];
    spectrum[bin] = {a.real() * b.real() - a.imag() * b.imag(),
                     a.real() * b.imag() + a.imag() * b.real()};
  }
}

}  // namespace

double onset_of(std::span<const float> response) {
  constexpr int kReach = 16;
  constexpr int kSteps = 16;
  double peak = 0.0;
  for (const float value : response) peak = std::max(peak, static_cast<double>(std::abs(value)));
  const double threshold = 0.1 * peak;
  if (peak == 0.0) return 0.0;
  const auto first =
      std::ranges::find_if(response, [&](float value) { return std::abs(value) >= threshold; });
  const auto coarse = static_cast<int>(first - response.begin());

  // Between samples: a sinc with a Hann window, in steps over the two samples before. From tap to
  // tap the sine changes its sign, and the phase of the window's cosine moves by a fixed angle.
  const double window_step = kPi / (kReach + 1);
  const std::complex<double> window_turn = std::polar(1.0, -window_step);
  const auto value_at = [&](double time) {
    double sum = 0.0;
    const int middle = static_cast<int>(std::floor(time));
    const int first_tap = std::max(0, middle - kReach + 1);
    const int last_tap = std::min(static_cast<int>(response.size()) - 1, middle + kReach);
    double sine = std::sin(kPi * (time - first_tap));
    std::complex<double> window = std::polar(1.0, window_step * (time - first_tap));
    for (int n = first_tap; n <= last_tap; ++n) {
      const double x = time - n;
      const double sinc = std::abs(x) < 1e-9 ? 1.0 : sine / (kPi * x);
      sum += response[n] * sinc * 0.5 * (1.0 + window.real());
      sine = -sine;
      window = {window.real() * window_turn.real() - window.imag() * window_turn.imag(),
                window.real() * window_turn.imag() + window.imag() * window_turn.real()};
    }
    return std::abs(sum);
  };
  double before = value_at(coarse - 2.0);
  for (int step = 1; step <= 2 * kSteps; ++step) {
    const double time = coarse - 2.0 + static_cast<double>(step) / kSteps;
    const double now = value_at(time);
    if (now >= threshold && before < threshold) {
      return time - (now - threshold) / (now - before) / kSteps;
    }
    before = now;
  }
  return coarse;
}

HrtfResponses farthest_shell(const SofaFile& file) {
  double farthest_m = 0.0;
  for (const Vector3& position : file.positions_m)
    farthest_m = std::max(farthest_m, norm(position));

  HrtfResponses set;
  set.sample_rate_hz = file.sample_rate_hz;
  set.distance_m = farthest_m;
  const double delay = largest_delay(file);
  set.taps = file.taps + static_cast<int>(std::ceil(delay));
  RealFft<double> fft(fast_fft_size(2 * set.taps));
  const double same_direction = std::cos(radians_from_degrees(0.02));
  for (std::size_t i = 0; i < file.positions_m.size(); ++i) {
    const double distance_m = norm(file.positions_m[i]);
    if (distance_m < 0.9 * farthest_m) continue;
    const Vector3 direction = file.positions_m[i] / distance_m;
    const bool seen = std::ranges::any_of(set.directions, [&](const Vector3& other) {
      return dot(other, direction) > same_direction;
    });
    if (seen) continue;
    set.directions.push_back(direction);
    set.responses.resize(set.directions.size() * 2 * set.taps, 0.0F);
    set.onsets.emplace_back();
    for (int ear = 0; ear < 2; ++ear) {
      const std::span<float> out = set.response(set.directions.size() - 1, ear);
      if (file.delays_samples[i][ear] > 0.0) {
        delay_response(file.response(i, ear), file.delays_samples[i][ear], fft, out);
      } else {
        std::ranges::copy(file.response(i, ear), out.begin());
      }
      set.onsets.back()[ear] = onset_of(out);
    }
  }
  if (!set.directions.empty()) set.shares = sphere_shares(set.directions);
  return set;
}

void equalize_diffuse_field(HrtfResponses& set) {
  constexpr double kLength_s = 512.0 / 44100.0;
  constexpr double kMost_db = 18.0;
  const int taps = set.taps + static_cast<int>(kLength_s * set.sample_rate_hz);
  RealFft<double> fft(fast_fft_size(4 * taps));

  // The set's level is its mean from 500 to 4000 Hz.
  const std::vector<double> field_db = diffuse_field_db(set, fft);
  const int low = static_cast<int>(500.0 * fft.size() / set.sample_rate_hz);
  const int high = static_cast<int>(std::min(4000.0, 0.45 * set.sample_rate_hz) * fft.size() /
                                    set.sample_rate_hz);
  const double level_db =
      std::reduce(field_db.begin() + low, field_db.begin() + high) / (high - low);
  std::vector<double> filter_nepers;
  for (const double value_db : field_db) {
    const double gain_db = std::clamp(level_db - value_db, -kMost_db, kMost_db) - level_db;
    filter_nepers.push_back(gain_db * std::log(10.0) / 20.0);
  }
  const std::vector<Complex> filter = minimum_phase(filter_nepers, fft);

  // Filter, and fade out the last eighth, where low frequencies would ring on. Only the filter's
  // first `taps` samples affect the samples that are kept.
  HrtfResponses equalized{set.sample_rate_hz, taps,      set.distance_m, set.directions, {},
                          set.onsets,         set.shares};
  equalized.responses.resize(set.directions.size() * 2 * taps);
  std::vector<double> impulse(fft.size());
  fft.inverse(filter, impulse);
  RealFft<float> shorter(fast_fft_size(set.taps + taps));
  std::vector<float> padded(shorter.size());
  std::transform(impulse.begin(), impulse.begin() + taps, padded.begin(),
                 [](double value) { return static_cast<float>(value); });
  std::vector<std::complex<float>> short_filter(shorter.bins());
  shorter.forward(padded, short_filter);
  const int fade = taps / 8;
  std::vector<std::complex<float>> spectrum(shorter.bins());
  for (std::size_t i = 0; i < set.directions.size(); ++i) {
    for (int ear = 0; ear < 2; ++ear) {
      std::ranges::fill(padded, 0.0F);
      std::ranges::copy(set.response(i, ear), padded.begin());
      shorter.forward(padded, spectrum);
      multiply(short_filter, spectrum);
      shorter.inverse(spectrum, padded);
      const std::span<float> out = equalized.response(i, ear);
      std::copy_n(padded.begin(), taps, out.begin());
      for (int tap = taps - fade; tap < taps; ++tap) {
        const double into = static_cast<double>(tap - (taps - fade)) / fade;
        out[tap] *= static_cast<float>(0.5 * (1.0 + std::cos(kPi * into)));
      }
    }
  }
  set = std::move(equalized);
}

void change_rate(HrtfResponses& set, int sample_rate_hz) {
  if (set.sample_rate_hz == sample_rate_hz) return;
  // The low-pass falls over the top 8 % below the lower Nyquist frequency; the lead-in and as much
  // behind the response hold its ringing.
  constexpr double kRoom_s = 0.002;
  constexpr double kFallFrom = 0.92;
  const int lead_in = static_cast<int>(kRoom_s * set.sample_rate_hz);
  const int used = set.taps + 2 * lead_in;
  // Transform sizes that last equally long at both rates.
  const int divisor = std::gcd(set.sample_rate_hz, sample_rate_hz);
  const int size_in = set.sample_rate_hz / divisor;
  const int repeats = 2 * ((used + 2 * size_in - 1) / (2 * size_in));
  RealFft<double> fft_in(size_in * repeats);
  RealFft<double> fft_out(sample_rate_hz / divisor * repeats);
  const int bins = std::min(fft_in.bins(), fft_out.bins());

  HrtfResponses resampled{sample_rate_hz, 0,         set.distance_m, set.directions, {},
                          set.onsets,     set.shares};
  const double ratio = static_cast<double>(sample_rate_hz) / set.sample_rate_hz;
  for (auto& onsets : resampled.onsets) {
    for (double& onset : onsets) onset = (onset + lead_in) * ratio;
  }
  resampled.taps =
      static_cast<int>(std::ceil(static_cast<double>(used) * sample_rate_hz / set.sample_rate_hz));
  resampled.taps = std::min(resampled.taps, fft_out.size());
  resampled.responses.resize(set.directions.size() * 2 * resampled.taps);
  std::vector<double> wave_in(fft_in.size(), 0.0);
  std::vector<double> wave_out(fft_out.size());
  std::vector<Complex> spectrum(std::max(fft_in.bins(), fft_out.bins()), 0.0);
  for (std::size_t i = 0; i < set.directions.size(); ++i) {
    for (int ear = 0; ear < 2; ++ear) {
      std::ranges::copy(set.response(i, ear), wave_in.begin() + lead_in);
      fft_in.forward(wave_in, std::span(spectrum).first(fft_in.bins()));
      for (int bin = 0; bin < bins; ++bin) {
        const double place = static_cast<double>(bin) / (bins - 1);
        const double fall = std::max(0.0, (place - kFallFrom) / (1.0 - kFallFrom));
        spectrum[bin] *= 0.5 * (1.0 + std::cos(kPi * fall));
      }
      std::fill(spectrum.begin() + bins, spectrum.end(), 0.0);
      fft_out.inverse(std::span(spectrum).first(fft_out.bins()), wave_out);
      // Of a response the spectrum is kept, not the waveform: no scaling by the transforms' sizes.
      std::transform(wave_out.begin(), wave_out.begin() + resampled.taps,
                     resampled.response(i, ear).begin(),
                     [](double value) { return static_cast<float>(value); });
    }
  }
  set = std::move(resampled);
}

}  // namespace earpoint
