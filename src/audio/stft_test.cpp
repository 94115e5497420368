#include <cmath>
#include <complex>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/audio/stft.h>
#include <earpoint/core/random.h>

namespace earpoint {
namespace {

constexpr double kTurn = 6.283185307179586476925286766559;

std::vector<float> noise(std::ptrdiff_t samples, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> signal(samples);
  for (float& x : signal) x = static_cast<float>(random.uniform(-1.0, 1.0));
  return signal;
}

/// One value by the definition: frame `frame` centred at frame * hop, the window centred in it.
std::complex<double> value_of(const std::vector<float>& signal, const StftShape& shape, int frame,
                              int bin) {
  std::complex<double> sum = 0.0;
  for (int n = 0; n < shape.window_size; ++n) {
    const int in_frame = (shape.fft_size - shape.window_size) / 2 + n;
    const std::ptrdiff_t at = std::ptrdiff_t{frame} * shape.hop - shape.fft_size / 2 + in_frame;
    if (at < 0 || at >= std::ssize(signal)) continue;
    const double cosine = std::cos(kTurn * n / shape.window_size);
    const double window = shape.window == Window::hann ? 0.5 - 0.5 * cosine : 0.54 - 0.46 * cosine;
    sum += double{signal[at]} * window *
           std::polar(1.0, -kTurn * std::fmod(double{1} * bin * in_frame, shape.fft_size) /
                               shape.fft_size);
  }
  return sum;
}

TEST(Stft, EqualsTheDefinition) {
  for (const StftShape shape : {StftShape{}, StftShape{256, 128, 64}, StftShape{1024, 600, 256},
                                StftShape{512, 512, 128, Window::hann}}) {
    for (const std::ptrdiff_t samples : {0, 1, 159, 160, 1000}) {
      const std::vector<float> signal = noise(samples, 1);
      Stft stft(shape);
      const Spectrogram spectrogram = stft.forward(signal);
      ASSERT_EQ(spectrogram.frames, 1 + samples / shape.hop);
      ASSERT_EQ(spectrogram.bins, shape.fft_size / 2 + 1);
      for (int k = 0; k < spectrogram.frames; ++k) {
        for (const int bin : {0, 1, 17, shape.fft_size / 2}) {
          // Float transforms of values of about sqrt(window_size).
          EXPECT_NEAR(std::abs(std::complex<double>(spectrogram.frame(k)[bin]) -
                               value_of(signal, shape, k, bin)),
                      0.0, 2e-5);
        }
      }
    }
  }
}

TEST(Stft, InverseGivesTheSignalBackToItsEnds) {
  for (const StftShape shape :
       {StftShape{}, StftShape{512, 512, 128, Window::hann}, StftShape{256, 128, 64}}) {
    for (const std::ptrdiff_t samples : {1, 160, 1000, 16000, 16159}) {
      const std::vector<float> signal = noise(samples, 2);
      Stft stft(shape);
      const std::vector<float> back = stft.inverse(stft.forward(signal), samples);
      ASSERT_EQ(std::ssize(back), samples);
      for (std::ptrdiff_t n = 0; n < samples; ++n) {
        // Where only one window reaches, its value is as small as 0.08, which magnifies float
        // rounding.
        ASSERT_NEAR(back[n], signal[n], 1e-5F) << n;
      }
    }
  }
}

TEST(Stft, InverseOfAChangedSpectrumIsTheLeastSquaresOne) {
  // The least-squares signal x of a spectrum S has <S - STFT(x), STFT(y)> = 0 for every y.
  const std::ptrdiff_t samples = 1000;
  Stft stft;
  Spectrogram target = stft.forward(noise(samples, 3));
  RandomStream random(4);
  for (auto& value : target.values) value *= static_cast<float>(random.uniform(0.0, 2.0));
  for (int k = 0; k < target.frames; ++k) {  // of a real signal
    target.frame(k)[0].imag(0);
    target.frame(k)[target.bins - 1].imag(0);
  }
  const Spectrogram nearest = stft.forward(stft.inverse(target, samples));
  const Spectrogram probe = stft.forward(noise(samples, 5));
  double product = 0.0;
  double scale = 0.0;
  for (std::size_t i = 0; i < probe.values.size(); ++i) {
    const std::size_t bin = i % static_cast<std::size_t>(probe.bins);
    // Bins between the ends also count for their mirror image.
    const double weight = bin == 0 || bin + 1 == static_cast<std::size_t>(probe.bins) ? 1.0 : 2.0;
    const std::complex<double> rest(target.values[i] - nearest.values[i]);
    const std::complex<double> y(probe.values[i]);
    product += weight * (rest * std::conj(y)).real();
    scale += weight * std::abs(rest) * std::abs(y);
  }
  EXPECT_NEAR(product / scale, 0.0, 1e-6);  // float rounding of the inner product
}

TEST(Stft, WrongShapesAreTheCallersBug) {
  EXPECT_THROW(Stft({512, 513, 160}), std::logic_error);
  EXPECT_THROW(Stft({512, 400, 0}), std::logic_error);
  Stft stft;
  const Spectrogram spectrogram = stft.forward(noise(1000, 6));
  EXPECT_THROW((void)stft.inverse(spectrogram, 2000), std::logic_error);
}

}  // namespace
}  // namespace earpoint
