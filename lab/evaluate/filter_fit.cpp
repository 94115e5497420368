#include "filter_fit.h"

#include <algorithm>

#include <earpoint/error.h>

namespace earpoint {
namespace {

double inner(std::span<const float> a, std::span<const float> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += double{a[i]} * b[i];
  return sum;
}

/// Written out because std::complex's product checks for NaN.
std::complex<float> product(std::complex<float> a, std::complex<float> b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

/// a += factor * b
void add(std::vector<float>& a, double factor, std::span<const float> b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += static_cast<float>(factor * b[i]);
}

/// Long enough for everything that a tap can reach, so that circular wrap-around reads zeros.
int circle_size(const FilterShape& shape, std::ptrdiff_t lead, std::ptrdiff_t samples) {
  EARPOINT_CHECK(shape.before >= 0 && shape.after > 0 && lead >= 0 && samples > 0);
  const std::ptrdiff_t past = std::max<std::ptrdiff_t>(0, shape.after - 1 - lead);
  return fast_fft_size(static_cast<int>(lead + samples + shape.before + past));
}

}  // namespace

FilterFit::FilterFit(FilterShape shape, std::ptrdiff_t lead, std::ptrdiff_t samples,
                     Options options)
    : shape_(shape),
      lead_(lead),
      samples_(samples),
      options_(options),
      fft_(circle_size(shape, lead, samples)),
      input_spectrum_(static_cast<std::size_t>(fft_.bins())),
      spectrum_(input_spectrum_.size()),
      circle_(static_cast<std::size_t>(fft_.size())) {}

void FilterFit::back_project(std::span<const float> output, std::vector<float>& taps) {
  std::ranges::fill(circle_, 0.0F);
  std::ranges::copy(output, circle_.begin() + lead_);
  fft_.forward(circle_, spectrum_);
  for (std::size_t k = 0; k < spectrum_.size(); ++k) {
    spectrum_[k] = product(spectrum_[k], std::conj(input_spectrum_[k]));
  }
  fft_.inverse(spectrum_, circle_);
  std::copy(circle_.end() - shape_.before, circle_.end(), taps.begin());
  std::copy_n(circle_.begin(), shape_.after, taps.begin() + shape_.before);
}

void FilterFit::apply_normal(std::span<const float> taps, std::vector<float>& result) {
  std::ranges::fill(circle_, 0.0F);
  std::copy_n(taps.begin(), shape_.before, circle_.end() - shape_.before);
  std::copy_n(taps.begin() + shape_.before, shape_.after, circle_.begin());
  fft_.forward(circle_, spectrum_);
  for (std::size_t k = 0; k < spectrum_.size(); ++k) {
    spectrum_[k] = product(spectrum_[k], input_spectrum_[k]);
  }
  fft_.inverse(spectrum_, circle_);
  const std::vector<float> heard(circle_.begin() + lead_, circle_.begin() + lead_ + samples_);
  back_project(heard, result);
}

std::vector<float> FilterFit::fit(std::span<const float> input, std::span<const float> output) {
  EARPOINT_CHECK(std::ssize(input) == lead_ + samples_ && std::ssize(output) == samples_);
  const auto count = static_cast<std::size_t>(shape_.before + shape_.after);
  std::vector<float> taps(count);
  const double energy = inner(input, input);
  if (energy == 0.0) return taps;
  std::ranges::fill(circle_, 0.0F);
  std::ranges::copy(input, circle_.begin());
  fft_.forward(circle_, input_spectrum_);

  std::vector<float> rest(count);
  back_project(output, rest);
  std::vector<float> direction = rest;
  std::vector<float> image(count);
  double rest_energy = inner(rest, rest);
  const double enough = 1e-12 * rest_energy;
  for (int step = 0; step < options_.steps && rest_energy > enough; ++step) {
    apply_normal(direction, image);
    add(image, options_.regularisation * energy, direction);
    const double length = rest_energy / inner(direction, image);
    add(taps, length, direction);
    add(rest, -length, image);
    const double next = inner(rest, rest);
    for (std::size_t i = 0; i < count; ++i) {
      direction[i] = rest[i] + static_cast<float>(next / rest_energy) * direction[i];
    }
    rest_energy = next;
  }
  return taps;
}

}  // namespace earpoint
