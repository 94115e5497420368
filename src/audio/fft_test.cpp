#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/fft.h>
#include <earpoint/core/random.h>

namespace earpoint {
namespace {

constexpr double kTurn = 6.283185307179586476925286766559;

std::vector<double> noise(int size, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<double> signal(size);
  for (double& x : signal) x = random.uniform(-1.0, 1.0);
  return signal;
}

/// One bin by the definition.
std::complex<double> bin_of(const std::vector<double>& signal, int k) {
  const auto size = static_cast<std::int64_t>(signal.size());
  std::complex<double> sum = 0.0;
  for (std::int64_t n = 0; n < size; ++n) {
    sum += signal[n] *
           std::polar(1.0, -kTurn * static_cast<double>(n * k % size) / static_cast<double>(size));
  }
  return sum;
}

// Every radix alone and mixed, odd sizes, primes that use the chirp transform, and the sizes of the
// delay estimator.
const std::vector<int> kSizes = {
    1,   2,   3,    4,    5,    6,    7,    8,    9,    10,   11,   12,    13,    14,    15,
    16,  17,  22,   26,   30,   31,   34,   60,   64,   97,   100,  105,   128,   143,   240,
    338, 512, 1000, 1001, 1024, 1994, 2048, 2310, 4410, 5929, 9973, 12000, 16001, 19946, 32000};

TEST(RealFft, EqualsTheDefinitionAtEverySize) {
  for (const int size : kSizes) {
    const std::vector<double> signal = noise(size, size);
    RealFft<double> fft(size);
    std::vector<std::complex<double>> spectrum(fft.bins());
    fft.forward(signal, spectrum);
    // All bins of small sizes, some of large ones.
    const int step = std::max(1, fft.bins() / 61);
    for (int k = 0; k < fft.bins(); k += step) {
      // The definition's own rounding dominates: at most a few 1e-16 in each of its terms.
      const double tolerance = 2e-15 * size + 1e-14;
      EXPECT_NEAR(std::abs(spectrum[k] - bin_of(signal, k)), 0.0, tolerance)
          << "size " << size << " bin " << k;
    }
  }
}

TEST(RealFft, InverseOfForwardIsTheSignal) {
  for (const int size : kSizes) {
    const std::vector<double> signal = noise(size, 2000000 + size);
    RealFft<double> fft(size);
    std::vector<std::complex<double>> spectrum(fft.bins());
    std::vector<double> back(size);
    fft.forward(signal, spectrum);
    fft.inverse(spectrum, back);
    for (int n = 0; n < size; ++n) {
      // A few roundings per pass.
      ASSERT_NEAR(back[n], signal[n], 4e-15) << "size " << size << " sample " << n;
    }
  }
}

TEST(RealFft, FloatFollowsDouble) {
  for (const int size : kSizes) {
    const std::vector<double> signal = noise(size, 3000000 + size);
    const std::vector<float> rounded(signal.begin(), signal.end());
    const std::vector<double> exact(rounded.begin(), rounded.end());
    RealFft<double> fft(size);
    RealFft<float> single(size);
    std::vector<std::complex<double>> spectrum(fft.bins());
    std::vector<std::complex<float>> single_spectrum(fft.bins());
    fft.forward(exact, spectrum);
    single.forward(rounded, single_spectrum);
    for (int k = 0; k < fft.bins(); ++k) {
      // Bins have the size sqrt(size / 3); float rounding adds up over the passes, and a chirp has
      // three times as many.
      ASSERT_NEAR(std::abs(spectrum[k] - std::complex<double>(single_spectrum[k])), 0.0,
                  1e-6 * std::sqrt(size))
          << "size " << size << " bin " << k;
    }
    std::vector<float> back(size);
    single.inverse(single_spectrum, back);
    for (int n = 0; n < size; ++n) {
      // Values up to 1, rounded over the passes of two transforms.
      ASSERT_NEAR(back[n], rounded[n], 3e-6F) << "size " << size;
    }
  }
}

TEST(RealFft, InverseIgnoresImaginaryPartsThatARealSignalCannotHave) {
  for (const int size : {8, 9}) {
    RealFft<double> fft(size);
    std::vector<std::complex<double>> spectrum(fft.bins());
    fft.forward(noise(size, 1), spectrum);
    std::vector<double> expected(size);
    std::vector<double> found(size);
    fft.inverse(spectrum, expected);
    spectrum[0].imag(3.0);
    if (size % 2 == 0) spectrum[size / 2].imag(-2.0);
    fft.inverse(spectrum, found);
    EXPECT_EQ(found, expected);
  }
}

TEST(RealFft, WrongShapesAreTheCallersBug) {
  RealFft<float> fft(8);
  std::vector<float> signal(7);
  std::vector<std::complex<float>> spectrum(5);
  EXPECT_THROW(fft.forward(signal, spectrum), std::logic_error);
  EXPECT_THROW(RealFft<float>(0), std::logic_error);
}

TEST(FastFftSize, IsTheNextEvenSizeMadeOfTwosThreesAndFives) {
  EXPECT_EQ(fast_fft_size(1), 2);
  EXPECT_EQ(fast_fft_size(7), 8);
  EXPECT_EQ(fast_fft_size(257), 270);
  EXPECT_EQ(fast_fft_size(513), 540);
  EXPECT_EQ(fast_fft_size(31999), 32000);
}

}  // namespace
}  // namespace earpoint
