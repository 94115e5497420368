#include <earpoint/audio/butterworth.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include <earpoint/error.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

using Complex = std::complex<double>;

/// Poles in z, one for each pair of complex conjugates; real ones singly.
struct Poles {
  std::vector<Complex> upper;
  std::vector<double> real;
  double gain = 1.0;
};

/// a / b by Smith's method (CACM 5, 1962).
Complex divide(Complex a, Complex b) {
  if (std::abs(b.real()) >= std::abs(b.imag())) {
    const double ratio = b.imag() / b.real();
    const double scale = 1.0 / (b.real() + b.imag() * ratio);
    return {(a.real() + a.imag() * ratio) * scale, (a.imag() - a.real() * ratio) * scale};
  }
  const double ratio = b.real() / b.imag();
  const double scale = 1.0 / (b.imag() + b.real() * ratio);
  return {(a.real() * ratio + a.imag()) * scale, (a.imag() * ratio - a.real()) * scale};
}

Poles bandpass_poles(double low_hz, double high_hz, double sample_rate_hz, int order) {
  // Frequencies in units of twice the sample rate, prewarped for the bilinear transform.
  // With poles this near to the unit circle the last bit of a coefficient moves the output by
  // 1e-11, so the arithmetic, down to the complex division, is done in the reference's way.
  const double low = std::tan(kPi * (low_hz / (sample_rate_hz / 2)) / 2);
  const double high = std::tan(kPi * (high_hz / (sample_rate_hz / 2)) / 2);
  const double width = high - low;
  const double middle = std::sqrt(low * high);

  Poles poles;
  Complex denominator = 1.0;
  for (const double sign : {1.0, -1.0}) {
    for (int m = 0; m < order; ++m) {
      const double angle = kPi * (2.0 * m + 1.0 - order) / (2.0 * order);
      const bool real_prototype = 2 * m + 1 == order;
      const Complex prototype = real_prototype ? Complex(-1.0, 0.0) : -std::polar(1.0, angle);
      const Complex half = prototype * (width / 2);
      const Complex root = std::sqrt(half * half - middle * middle);
      const Complex analogue = half + sign * root;
      const Complex pole = divide(1.0 + analogue, 1.0 - analogue);
      denominator *= 1.0 - analogue;
      if (real_prototype && root.imag() == 0.0) {
        poles.real.push_back(pole.real());
      } else if (pole.imag() > 0.0) {
        poles.upper.push_back(pole);
      }
    }
  }
  poles.gain = std::pow(width, order) * divide(1.0, denominator).real();
  return poles;
}

/// Takes the zero at +1 or -1 that is nearer to the pole, or the other one if none is left there.
double take_zero(Complex pole, int& zeros_at_plus_one, int& zeros_at_minus_one) {
  const bool plus = zeros_at_minus_one == 0 ||
                    (zeros_at_plus_one > 0 && std::abs(pole - 1.0) < std::abs(pole + 1.0));
  --(plus ? zeros_at_plus_one : zeros_at_minus_one);
  return plus ? 1.0 : -1.0;
}

/// A section and its state: transposed direct form II.
struct RunningSection {
  SecondOrderSection s;
  double z1 = 0.0;
  double z2 = 0.0;
};

/// One pass through the cascade, in place, from the steady state for the first sample. Each sample
/// goes through all sections before the next one, so that the latencies of the sections overlap.
void filter_forward(std::span<const SecondOrderSection> sections, std::span<double> signal) {
  if (signal.empty()) return;
  double level = signal[0];
  std::vector<RunningSection> cascade;
  for (const SecondOrderSection& s : sections) {
    const double section_gain = (s.b0 + s.b1 + s.b2) / (1.0 + s.a1 + s.a2);
    RunningSection running{.s = s, .z2 = (s.b2 - s.a2 * section_gain) * level};
    running.z1 = (s.b1 - s.a1 * section_gain) * level + running.z2;
    cascade.push_back(running);
    level *= section_gain;
  }
  for (double& sample : signal) {
    double x = sample;
    for (RunningSection& r : cascade) {
      const double y = r.s.b0 * x + r.z1;
      r.z1 = r.s.b1 * x - r.s.a1 * y + r.z2;
      r.z2 = r.s.b2 * x - r.s.a2 * y;
      x = y;
    }
    sample = x;
  }
}

}  // namespace

std::vector<SecondOrderSection> butterworth_bandpass(double low_hz, double high_hz,
                                                     double sample_rate_hz, int order) {
  EARPOINT_CHECK(order > 0 && low_hz > 0.0 && low_hz < high_hz && high_hz < sample_rate_hz / 2);
  const Poles poles = bandpass_poles(low_hz, high_hz, sample_rate_hz, order);

  // Pairs of poles, nearest to the unit circle first.
  std::vector<std::pair<Complex, Complex>> pairs;
  for (const Complex pole : poles.upper) pairs.emplace_back(pole, std::conj(pole));
  std::vector<double> real = poles.real;
  std::ranges::sort(real, {}, [](double p) { return 1.0 - std::abs(p); });
  for (std::size_t i = 0; i + 1 < real.size(); i += 2) pairs.emplace_back(real[i], real[i + 1]);
  std::ranges::sort(pairs, {}, [](const auto& pair) { return 1.0 - std::abs(pair.first); });

  std::vector<SecondOrderSection> sections;
  int plus = order;
  int minus = order;
  for (const auto& [p, q] : pairs) {
    const double zero_a = take_zero(p, plus, minus);
    const double zero_b = take_zero(p, plus, minus);
    sections.push_back({1.0, -(zero_a + zero_b), zero_a * zero_b, -(p + q).real(), (p * q).real()});
  }
  std::ranges::reverse(sections);
  sections.front().b0 *= poles.gain;
  sections.front().b1 *= poles.gain;
  sections.front().b2 *= poles.gain;
  return sections;
}

Crossover linkwitz_riley(double cutoff_hz, double sample_rate_hz) {
  EARPOINT_CHECK(0.0 < cutoff_hz && cutoff_hz < sample_rate_hz / 2.0);
  constexpr int kOrder = 4;  // of the Butterworth filter that is applied twice
  const double k = std::tan(kPi * cutoff_hz / sample_rate_hz);
  Crossover crossover;
  for (int pair = 0; pair < kOrder / 2; ++pair) {
    const double damping = 2.0 * std::sin(kPi * (2 * pair + 1) / (2.0 * kOrder));
    const double scale = 1.0 / (1.0 + k * damping + k * k);
    SecondOrderSection section;
    section.a1 = 2.0 * (k * k - 1.0) * scale;
    section.a2 = (1.0 - k * damping + k * k) * scale;
    section.b0 = section.b2 = k * k * scale;
    section.b1 = 2.0 * section.b0;
    crossover.low.insert(crossover.low.end(), 2, section);
    section.b0 = section.b2 = scale;
    section.b1 = -2.0 * scale;
    crossover.high.insert(crossover.high.end(), 2, section);
  }
  return crossover;
}

std::ptrdiff_t zero_phase_extension(std::span<const SecondOrderSection> sections) {
  // Three times the taps of the cascade multiplied out.
  const auto first_order_zeros = std::ranges::count(sections, 0.0, &SecondOrderSection::b2);
  const auto first_order_poles = std::ranges::count(sections, 0.0, &SecondOrderSection::a2);
  return 3 * (2 * std::ssize(sections) + 1 - std::min(first_order_zeros, first_order_poles));
}

void filter_zero_phase(std::span<const SecondOrderSection> sections, std::span<const double> in,
                       std::span<double> out) {
  const std::ptrdiff_t edge = zero_phase_extension(sections);
  const std::ptrdiff_t samples = std::ssize(in);
  EARPOINT_CHECK(samples > edge && std::ssize(out) == samples);
  std::vector<double> extended(samples + 2 * edge);
  for (std::ptrdiff_t i = 0; i < edge; ++i) {
    extended[i] = 2.0 * in[0] - in[edge - i];
    extended[edge + samples + i] = 2.0 * in[samples - 1] - in[samples - 2 - i];
  }
  std::ranges::copy(in, extended.begin() + edge);
  filter_forward(sections, extended);
  std::ranges::reverse(extended);
  filter_forward(sections, extended);
  std::ranges::reverse(extended);
  std::copy_n(extended.begin() + edge, samples, out.begin());
}

SectionFilter::SectionFilter(std::span<const SecondOrderSection> sections) {
  for (const SecondOrderSection& section : sections) running_.push_back({section});
}

double SectionFilter::process(double sample) {
  // An offset at -500 dB keeps decaying states from becoming denormal, which is 100 times slower.
  constexpr double kNothing = 1e-25;
  double value = sample + kNothing;
  for (Running& r : running_) {
    const double in = value;
    value = r.section.b0 * in + r.z1;
    r.z1 = r.section.b1 * in - r.section.a1 * value + r.z2;
    r.z2 = r.section.b2 * in - r.section.a2 * value;
  }
  return value;
}

void SectionFilter::reset() {
  for (Running& r : running_) r.z1 = r.z2 = 0.0;
}

}  // namespace earpoint
