#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace earpoint {

/// Periodic windows: 0.54 - 0.46 cos(2 pi n / size), and 0.5 - 0.5 cos(2 pi n / size).
enum class Window { hamming, hann };

/// How a short-time Fourier transform cuts its signal. The defaults are those of the published
/// metrics and losses.
struct StftShape {
  int fft_size = 512;
  int window_size = 400;  ///< lies in the middle of the fft_size samples
  int hop = 160;
  Window window = Window::hamming;

  friend bool operator==(const StftShape&, const StftShape&) = default;
};

/// A short-time spectrum, row-major [frames][bins].
struct Spectrogram {
  int frames = 0;
  int bins = 0;
  std::vector<std::complex<float>> values;

  [[nodiscard]] std::span<std::complex<float>> frame(int index);
  [[nodiscard]] std::span<const std::complex<float>> frame(int index) const;
};

/// Short-time Fourier transform with centred frames: frame k is centred at sample k * hop, and the
/// signal continues as zeros on both sides. Not normalised: X = sum x w e^(-i ...).
/// One object per thread.
class Stft {
 public:
  /// @param shape  0 < window_size <= fft_size, hop > 0
  explicit Stft(StftShape shape = {});
  ~Stft();
  Stft(Stft&&) noexcept;
  Stft& operator=(Stft&&) noexcept;

  [[nodiscard]] const StftShape& shape() const;
  /// fft_size / 2 + 1
  [[nodiscard]] int bins() const;
  /// 1 + floor(samples / hop)
  [[nodiscard]] int frames(std::ptrdiff_t samples) const;
  /// shape [window_size]
  [[nodiscard]] std::span<const float> window() const;

  /// @param signal  shape [samples]
  [[nodiscard]] Spectrogram forward(std::span<const float> signal);

  /// The signal whose spectrum is nearest to `spectrogram` in the least-squares sense (Griffin and
  /// Lim, IEEE Trans. ASSP 32, 1984); exact for an unchanged spectrum.
  /// @param spectrogram  bins() bins, frames(samples) frames
  /// @param samples      length of the signal; hop must be at most half of window_size
  [[nodiscard]] std::vector<float> inverse(const Spectrogram& spectrogram, std::ptrdiff_t samples);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
