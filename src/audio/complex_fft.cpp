#include "complex_fft.h"

#include "roots_of_unity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include <earpoint/audio/fft.h>
#include <earpoint/core/vector_clones.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kTurn = 6.283185307179586476925286766559;
constexpr int kLargestRadix = 13;
/// Distance between real and imaginary parts: at a power of two they would compete for the same
/// cache lines.
template <typename T>
constexpr std::size_t kGap = 1088 / sizeof(T);

template <typename T>
struct Complex {
  T re;
  T im;
};

template <typename T>
Complex<T> operator+(Complex<T> a, Complex<T> b) {
  return {a.re + b.re, a.im + b.im};
}
template <typename T>
Complex<T> operator-(Complex<T> a, Complex<T> b) {
  return {a.re - b.re, a.im - b.im};
}
template <typename T>
Complex<T> operator*(Complex<T> a, Complex<T> b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
/// -i a
template <typename T>
Complex<T> turned_back(Complex<T> a) {
  return {a.im, -a.re};
}

/// Cosines and sines of k turns / Radix, for the odd butterflies.
template <typename T, int Radix>
struct Roots {
  std::array<T, Radix> cosine;
  std::array<T, Radix> sine;
  Roots() {
    for (int k = 0; k < Radix; ++k) {
      cosine[k] = static_cast<T>(std::cos(kTurn * k / Radix));
      sine[k] = static_cast<T>(std::sin(kTurn * k / Radix));
    }
  }
};

/// The transform of Radix values, in place.
template <typename T, int Radix>
struct Butterfly {
  Roots<T, Radix> roots;

  // Element k and its mirror image, Radix - k, share their products: the sums of mirrored inputs
  // meet the cosines, the differences the sines.
  void operator()(std::array<Complex<T>, Radix>& v) const {
    constexpr int kHalf = (Radix - 1) / 2;
    std::array<Complex<T>, kHalf> sum;
    std::array<Complex<T>, kHalf> difference;
    Complex<T> total = v[0];
    for (int j = 1; j <= kHalf; ++j) {
      sum[j - 1] = v[j] + v[Radix - j];
      difference[j - 1] = v[j] - v[Radix - j];
      total = total + sum[j - 1];
    }
    const Complex<T> first = v[0];
    v[0] = total;
    for (int k = 1; k <= kHalf; ++k) {
      Complex<T> even = first;
      Complex<T> odd{};
      for (int j = 1; j <= kHalf; ++j) {
        const T c = roots.cosine[j * k % Radix];
        const T s = roots.sine[j * k % Radix];
        even = even + Complex<T>{c * sum[j - 1].re, c * sum[j - 1].im};
        odd = odd + Complex<T>{s * difference[j - 1].re, s * difference[j - 1].im};
      }
      v[k] = even + turned_back(odd);
      v[Radix - k] = even - turned_back(odd);
    }
  }
};

template <typename T>
struct Butterfly<T, 2> {
  void operator()(std::array<Complex<T>, 2>& v) const {
    const Complex<T> a = v[0];
    v[0] = a + v[1];
    v[1] = a - v[1];
  }
};

template <typename T>
struct Butterfly<T, 4> {
  void operator()(std::array<Complex<T>, 4>& v) const {
    const Complex<T> a = v[0] + v[2];
    const Complex<T> b = v[0] - v[2];
    const Complex<T> c = v[1] + v[3];
    const Complex<T> d = turned_back(v[1] - v[3]);
    v[0] = a + c;
    v[1] = b + d;
    v[2] = a - c;
    v[3] = b - d;
  }
};

/// Where one pass reads and writes.
template <typename T>
struct PassArrays {
  const T* in_re;
  const T* in_im;
  T* out_re;
  T* out_im;
  const T* cosines;
  const T* sines;
};

/// One column of a pass: Radix values `in_step` apart are transformed and stored `stride` apart.
template <typename T, int Radix>
void run_column(const Butterfly<T, Radix>& butterfly, const PassArrays<T>& a, std::ptrdiff_t in,
                std::ptrdiff_t in_step, std::ptrdiff_t out, std::ptrdiff_t stride,
                const std::array<Complex<T>, Radix - 1>& twiddle) {
  std::array<Complex<T>, Radix> v;
  for (int j = 0; j < Radix; ++j) v[j] = {a.in_re[in + j * in_step], a.in_im[in + j * in_step]};
  butterfly(v);
  a.out_re[out] = v[0].re;
  a.out_im[out] = v[0].im;
  for (int k = 1; k < Radix; ++k) {
    const Complex<T> y = v[k] * twiddle[k - 1];
    a.out_re[out + k * stride] = y.re;
    a.out_im[out + k * stride] = y.im;
  }
}

template <typename T, int Radix>
void run_pass(std::ptrdiff_t blocks, std::ptrdiff_t stride, const PassArrays<T>& a) {
  const Butterfly<T, Radix> butterfly;
  const std::ptrdiff_t in_step = blocks * stride;
  const auto twiddles = [&](std::ptrdiff_t p) {
    std::array<Complex<T>, Radix - 1> twiddle;
    for (int k = 0; k + 1 < Radix; ++k) {
      twiddle[k] = {a.cosines[k * blocks + p], a.sines[k * blocks + p]};
    }
    return twiddle;
  };
  if (stride == 1) {  // blocks side by side in vectors, as there are no columns
    EARPOINT_INDEPENDENT_PASSES
    for (std::ptrdiff_t p = 0; p < blocks; ++p) {
      run_column<T, Radix>(butterfly, a, p, in_step, p * Radix, 1, twiddles(p));
    }
    return;
  }
  for (std::ptrdiff_t p = 0; p < blocks; ++p) {
    const auto twiddle = twiddles(p);
    EARPOINT_INDEPENDENT_PASSES
    for (std::ptrdiff_t q = 0; q < stride; ++q) {
      run_column<T, Radix>(butterfly, a, p * stride + q, in_step, p * stride * Radix + q, stride,
                           twiddle);
    }
  }
}

template <typename T>
void run_pass_of_any_radix(int radix, std::ptrdiff_t blocks, std::ptrdiff_t stride,
                           const PassArrays<T>& arrays) {
  switch (radix) {
    case 2:
      return run_pass<T, 2>(blocks, stride, arrays);
    case 3:
      return run_pass<T, 3>(blocks, stride, arrays);
    case 4:
      return run_pass<T, 4>(blocks, stride, arrays);
    case 5:
      return run_pass<T, 5>(blocks, stride, arrays);
    case 7:
      return run_pass<T, 7>(blocks, stride, arrays);
    case 11:
      return run_pass<T, 11>(blocks, stride, arrays);
    default:
      return run_pass<T, kLargestRadix>(blocks, stride, arrays);
  }
}

[[gnu::flatten]] EARPOINT_VECTOR_CLONES void run_pass_of_radix(int radix, std::ptrdiff_t blocks,
                                                               std::ptrdiff_t stride,
                                                               const PassArrays<float>& arrays) {
  run_pass_of_any_radix(radix, blocks, stride, arrays);
}

[[gnu::flatten]] EARPOINT_VECTOR_CLONES void run_pass_of_radix(int radix, std::ptrdiff_t blocks,
                                                               std::ptrdiff_t stride,
                                                               const PassArrays<double>& arrays) {
  run_pass_of_any_radix(radix, blocks, stride, arrays);
}

/// @return the radices of the passes, or nothing if a prime factor is too large
std::vector<int> radices_of(int size) {
  std::vector<int> radices;
  for (const int radix : {4, 2, 3, 5, 7, 11, kLargestRadix}) {
    while (size % radix == 0) {
      radices.push_back(radix);
      size /= radix;
    }
  }
  return size == 1 ? radices : std::vector<int>{};
}

}  // namespace

/// Bluestein: nk = (n^2 + k^2 - (k - n)^2) / 2 turns the transform into a convolution with a chirp,
/// done at a size that has passes.
template <typename T>
struct ComplexFft<T>::Chirp {
  explicit Chirp(int size) : fft(fast_fft_size(2 * size - 1)) {
    const auto padded = static_cast<std::size_t>(fft.size());
    cosine.resize(size);
    sine.resize(size);
    kernel_re.resize(padded);
    kernel_im.resize(padded);
    work_re.resize(padded);
    work_im.resize(padded);
    const RootsOfUnity roots(2 * std::int64_t{size});
    for (std::int64_t n = 0; n < size; ++n) {
      const std::complex<double> root = roots.at(n * n);
      cosine[n] = static_cast<T>(root.real());
      sine[n] = static_cast<T>(-root.imag());
      for (const auto at :
           {static_cast<std::size_t>(n), (padded - static_cast<std::size_t>(n)) % padded}) {
        kernel_re[at] = cosine[n] / static_cast<T>(padded);
        kernel_im[at] = -sine[n] / static_cast<T>(padded);
      }
    }
    fft.forward(kernel_re.data(), kernel_im.data());
  }

  void forward(T* real, T* imaginary) {
    const std::size_t size = cosine.size();
    std::fill(work_re.begin(), work_re.end(), T{0});
    std::fill(work_im.begin(), work_im.end(), T{0});
    for (std::size_t n = 0; n < size; ++n) {
      work_re[n] = real[n] * cosine[n] - imaginary[n] * sine[n];
      work_im[n] = real[n] * sine[n] + imaginary[n] * cosine[n];
    }
    fft.forward(work_re.data(), work_im.data());
    for (std::size_t k = 0; k < work_re.size(); ++k) {
      const Complex<T> y =
          Complex<T>{work_re[k], work_im[k]} * Complex<T>{kernel_re[k], kernel_im[k]};
      work_re[k] = y.re;
      work_im[k] = y.im;
    }
    fft.forward(work_im.data(), work_re.data());
    for (std::size_t k = 0; k < size; ++k) {
      real[k] = work_re[k] * cosine[k] - work_im[k] * sine[k];
      imaginary[k] = work_re[k] * sine[k] + work_im[k] * cosine[k];
    }
  }

  ComplexFft fft;
  std::vector<T> cosine;
  std::vector<T> sine;
  std::vector<T> kernel_re;
  std::vector<T> kernel_im;
  std::vector<T> work_re;
  std::vector<T> work_im;
};

template <typename T>
ComplexFft<T>::ComplexFft(int size) : size_(size) {
  EARPOINT_CHECK(size >= 1);
  if (size == 1) return;
  plan_passes();
  if (passes_.empty()) {
    chirp_ = std::make_unique<Chirp>(size);
  } else {
    scratch_.resize(2 * static_cast<std::size_t>(size) + kGap<T>);
  }
}

template <typename T>
ComplexFft<T>::~ComplexFft() = default;
template <typename T>
ComplexFft<T>::ComplexFft(ComplexFft&&) noexcept = default;
template <typename T>
ComplexFft<T>& ComplexFft<T>::operator=(ComplexFft&&) noexcept = default;

template <typename T>
void ComplexFft<T>::plan_passes() {
  const RootsOfUnity roots(size_);
  int left = size_;
  int stride = 1;
  for (const int radix : radices_of(size_)) {
    const int blocks = left / radix;
    Pass pass{radix, blocks, stride, {}, {}};
    for (int k = 1; k < radix; ++k) {
      for (int p = 0; p < blocks; ++p) {
        const std::complex<double> root = roots.at(std::int64_t{p} * k * stride);
        pass.cosines.push_back(static_cast<T>(root.real()));
        pass.sines.push_back(static_cast<T>(-root.imag()));
      }
    }
    passes_.push_back(std::move(pass));
    left = blocks;
    stride *= radix;
  }
}

template <typename T>
void ComplexFft<T>::forward(T* real, T* imaginary) {
  if (chirp_) return chirp_->forward(real, imaginary);
  if (passes_.empty()) return;  // of one number, which is its own spectrum
  std::pair<T*, T*> from{real, imaginary};
  std::pair<T*, T*> to{scratch_.data(), scratch_.data() + size_ + kGap<T>};
  for (const Pass& pass : passes_) {
    run_pass_of_radix(pass.radix, pass.blocks, pass.stride,
                      PassArrays<T>{from.first, from.second, to.first, to.second,
                                    pass.cosines.data(), pass.sines.data()});
    std::swap(from, to);
  }
  if (from.first != real) {
    std::copy_n(from.first, size_, real);
    std::copy_n(from.second, size_, imaginary);
  }
}

template class ComplexFft<float>;
template class ComplexFft<double>;

}  // namespace earpoint
