#pragma once

#include <memory>
#include <vector>

namespace earpoint {

/// Complex Fourier transform of one size, real and imaginary parts in separate arrays (so that
/// every loop runs over plain numbers). Self-sorting (Stockham) passes of radix 4, 2, 3, 5, 7, 11
/// and 13; sizes with a larger prime factor go through Bluestein's chirp transform.
/// Sources: Stockham, AFIPS 28 (1966); Bluestein, IEEE Trans. AU 18 (1970); the odd butterflies are
/// the definition with the symmetric terms paired.
template <typename T>
class ComplexFft {
 public:
  /// @param size  >= 1
  explicit ComplexFft(int size);
  ~ComplexFft();
  ComplexFft(ComplexFft&&) noexcept;
  ComplexFft& operator=(ComplexFft&&) noexcept;

  [[nodiscard]] int size() const { return size_; }

  /// In place, X[k] = sum_n x[n] e^(-2 pi i k n / size); both arrays have `size` elements.
  /// With the two arrays exchanged it is the inverse times `size`.
  void forward(T* real, T* imaginary);

 private:
  struct Pass {
    int radix;
    int blocks;              // what is left of the length after this and the earlier passes
    int stride;              // product of the earlier radices
    std::vector<T> cosines;  // twiddles, shape [radix - 1][blocks]
    std::vector<T> sines;    // with the sign of the forward transform
  };
  struct Chirp;

  void plan_passes();

  int size_;
  std::vector<Pass> passes_;
  std::vector<T> scratch_;
  std::unique_ptr<Chirp> chirp_;
};

extern template class ComplexFft<float>;
extern template class ComplexFft<double>;

}  // namespace earpoint
