#include <earpoint/audio/fft.h>

#include "complex_fft.h"
#include "roots_of_unity.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include <earpoint/error.h>

namespace earpoint {

/// An even size is done as a complex transform of half the size, with the even samples as real
/// parts and the odd ones as imaginary parts; an odd size as a complex transform of its own size.
template <typename T>
struct RealFft<T>::State {
  explicit State(int size_in)
      : size(size_in), half(size_in % 2 == 0), fft(size_in % 2 == 0 ? size_in / 2 : size_in) {
    real.resize(fft.size());
    imaginary.resize(fft.size());
    if (!half) return;
    const RootsOfUnity roots(size);
    for (int k = 0; k <= size / 4; ++k) {
      cosine.push_back(static_cast<T>(roots.at(k).real()));
      sine.push_back(static_cast<T>(roots.at(k).imag()));
    }
  }

  int size;
  bool half;
  ComplexFft<T> fft;
  std::vector<T> real;
  std::vector<T> imaginary;
  std::vector<T> cosine;
  std::vector<T> sine;
};

template <typename T>
RealFft<T>::RealFft(int size) {
  EARPOINT_CHECK(size >= 1);
  state_ = std::make_unique<State>(size);
}
template <typename T>
RealFft<T>::~RealFft() = default;
template <typename T>
RealFft<T>::RealFft(RealFft&&) noexcept = default;
template <typename T>
RealFft<T>& RealFft<T>::operator=(RealFft&&) noexcept = default;

template <typename T>
int RealFft<T>::size() const {
  return state_->size;
}
template <typename T>
int RealFft<T>::bins() const {
  return state_->size / 2 + 1;
}

template <typename T>
void RealFft<T>::forward(std::span<const T> signal, std::span<std::complex<T>> spectrum) {
  State& s = *state_;
  EARPOINT_CHECK(std::ssize(signal) == s.size && std::ssize(spectrum) == bins());
  if (!s.half) {
    for (int n = 0; n < s.size; ++n) {
      s.real[n] = signal[n];
      s.imaginary[n] = 0;
    }
    s.fft.forward(s.real.data(), s.imaginary.data());
    for (int k = 0; k < bins(); ++k) spectrum[k] = {s.real[k], s.imaginary[k]};
    spectrum[0].imag(0);
    return;
  }
  const int half = s.size / 2;
  for (int n = 0; n < half; ++n) {
    s.real[n] = signal[2 * n];
    s.imaginary[n] = signal[2 * n + 1];
  }
  s.fft.forward(s.real.data(), s.imaginary.data());
  spectrum[0] = {s.real[0] + s.imaginary[0], 0};
  spectrum[half] = {s.real[0] - s.imaginary[0], 0};
  // Bins k and half - k together: E is the spectrum of the even samples, O of the odd ones, and
  // X[k] = E + w^k O, X[half - k] = conj(E - w^k O).
  for (int k = 1; k <= half / 2; ++k) {
    const int mirror = half - k;
    const T even_re = (s.real[k] + s.real[mirror]) / 2;
    const T even_im = (s.imaginary[k] - s.imaginary[mirror]) / 2;
    const T odd_re = (s.imaginary[k] + s.imaginary[mirror]) / 2;
    const T odd_im = (s.real[mirror] - s.real[k]) / 2;
    const T turned_re = odd_re * s.cosine[k] + odd_im * s.sine[k];
    const T turned_im = odd_im * s.cosine[k] - odd_re * s.sine[k];
    spectrum[k] = {even_re + turned_re, even_im + turned_im};
    spectrum[mirror] = {even_re - turned_re, turned_im - even_im};
  }
}

template <typename T>
void RealFft<T>::inverse(std::span<const std::complex<T>> spectrum, std::span<T> signal) {
  State& s = *state_;
  EARPOINT_CHECK(std::ssize(signal) == s.size && std::ssize(spectrum) == bins());
  const T scale = T{1} / static_cast<T>(s.size);
  if (!s.half) {
    s.real[0] = spectrum[0].real() * scale;
    s.imaginary[0] = 0;
    for (int k = 1; k < bins(); ++k) {
      s.real[k] = s.real[s.size - k] = spectrum[k].real() * scale;
      s.imaginary[k] = spectrum[k].imag() * scale;
      s.imaginary[s.size - k] = -s.imaginary[k];
    }
    s.fft.forward(s.imaginary.data(), s.real.data());
    for (int n = 0; n < s.size; ++n) signal[n] = s.real[n];
    return;
  }
  const int half = s.size / 2;
  s.real[0] = (spectrum[0].real() + spectrum[half].real()) * scale;
  s.imaginary[0] = (spectrum[0].real() - spectrum[half].real()) * scale;
  for (int k = 1; k <= half / 2; ++k) {
    const int mirror = half - k;
    const std::complex<T> a = spectrum[k];
    const std::complex<T> b = spectrum[mirror];
    const T even_re = (a.real() + b.real()) * scale;
    const T even_im = (a.imag() - b.imag()) * scale;
    const T turned_re = (a.real() - b.real()) * scale;
    const T turned_im = (a.imag() + b.imag()) * scale;
    const T odd_re = turned_re * s.cosine[k] - turned_im * s.sine[k];
    const T odd_im = turned_im * s.cosine[k] + turned_re * s.sine[k];
    s.real[k] = even_re - odd_im;
    s.imaginary[k] = even_im + odd_re;
    s.real[mirror] = even_re + odd_im;
    s.imaginary[mirror] = odd_re - even_im;
  }
  s.fft.forward(s.imaginary.data(), s.real.data());
  for (int n = 0; n < half; ++n) {
    signal[2 * n] = s.real[n];
    signal[2 * n + 1] = s.imaginary[n];
  }
}

template class RealFft<float>;
template class RealFft<double>;

int fast_fft_size(int size) {
  EARPOINT_CHECK(size >= 1);
  for (int candidate = size + size % 2;; candidate += 2) {
    int rest = candidate;
    for (const int factor : {2, 3, 5}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) return candidate;
  }
}

}  // namespace earpoint
