#pragma once

#include <complex>
#include <memory>
#include <span>

namespace earpoint {

/// Discrete Fourier transform of real signals, X[k] = sum_n x[n] e^(-2 pi i k n / size).
///
/// Any size >= 1. Sizes whose prime factors are at most 13 cost O(size log size) with a small
/// constant; others go through Bluestein's chirp transform, about five times slower.
/// Error: below 1e-15 (double) or 1e-6 (float) times the root-mean-square of the output.
/// An object holds its own work space: use one per thread. No allocation after construction.
template <typename T>
class RealFft {
 public:
  /// @param size  samples of the real signal, >= 1
  explicit RealFft(int size);
  ~RealFft();
  RealFft(RealFft&&) noexcept;
  RealFft& operator=(RealFft&&) noexcept;

  [[nodiscard]] int size() const;
  /// Bins of the half spectrum: size / 2 + 1.
  [[nodiscard]] int bins() const;

  /// @param signal    shape [size]
  /// @param spectrum  shape [bins]; bin 0, and bin size/2 of an even size, come out real
  void forward(std::span<const T> signal, std::span<std::complex<T>> spectrum);

  /// The inverse, scaled by 1/size, so that inverse(forward(x)) is x.
  /// @param spectrum  shape [bins]; the imaginary parts of bin 0, and of bin size/2 of an even
  ///                  size, are ignored
  /// @param signal    shape [size]
  void inverse(std::span<const std::complex<T>> spectrum, std::span<T> signal);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

extern template class RealFft<float>;
extern template class RealFft<double>;

/// @return the smallest size >= `size` whose only prime factors are 2, 3 and 5, and even:
///         a fast size for convolutions
[[nodiscard]] int fast_fft_size(int size);

}  // namespace earpoint
