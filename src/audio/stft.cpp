#include <earpoint/audio/stft.h>

#include <algorithm>
#include <cmath>

#include <earpoint/audio/fft.h>
#include <earpoint/error.h>

namespace earpoint {

std::span<std::complex<float>> Spectrogram::frame(int index) {
  EARPOINT_DCHECK(index >= 0 && index < frames);
  return std::span(values).subspan(static_cast<std::size_t>(index) * bins, bins);
}

std::span<const std::complex<float>> Spectrogram::frame(int index) const {
  EARPOINT_DCHECK(index >= 0 && index < frames);
  return std::span(values).subspan(static_cast<std::size_t>(index) * bins, bins);
}

struct Stft::State {
  explicit State(const StftShape& shape_in)
      : shape(shape_in), fft(shape_in.fft_size), frame(shape_in.fft_size) {
    const double mean = shape.window == Window::hamming ? 0.54 : 0.5;
    for (int n = 0; n < shape.window_size; ++n) {
      const double turn = 6.283185307179586476925286766559 * n / shape.window_size;
      window.push_back(static_cast<float>(mean - (1.0 - mean) * std::cos(turn)));
    }
  }

  /// Where the window of a frame begins in the signal; negative at the front.
  [[nodiscard]] std::ptrdiff_t window_start(int frame_index) const {
    return std::ptrdiff_t{frame_index} * shape.hop - shape.fft_size / 2 + window_offset();
  }
  [[nodiscard]] int window_offset() const { return (shape.fft_size - shape.window_size) / 2; }

  StftShape shape;
  RealFft<float> fft;
  std::vector<float> frame;
  std::vector<float> window;
};

Stft::Stft(StftShape shape) {
  EARPOINT_CHECK(shape.window_size > 0 && shape.window_size <= shape.fft_size && shape.hop > 0);
  state_ = std::make_unique<State>(shape);
}
Stft::~Stft() = default;
Stft::Stft(Stft&&) noexcept = default;
Stft& Stft::operator=(Stft&&) noexcept = default;

const StftShape& Stft::shape() const { return state_->shape; }
int Stft::bins() const { return state_->shape.fft_size / 2 + 1; }
int Stft::frames(std::ptrdiff_t samples) const {
  return 1 + static_cast<int>(samples / state_->shape.hop);
}
std::span<const float> Stft::window() const { return state_->window; }

Spectrogram Stft::forward(std::span<const float> signal) {
  State& s = *state_;
  Spectrogram result{frames(std::ssize(signal)), bins(), {}};
  result.values.resize(static_cast<std::size_t>(result.frames) * result.bins);
  for (int k = 0; k < result.frames; ++k) {
    std::ranges::fill(s.frame, 0.0F);
    const std::ptrdiff_t start = s.window_start(k);
    const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, -start);
    const std::ptrdiff_t last =
        std::min<std::ptrdiff_t>(s.shape.window_size, std::ssize(signal) - start);
    for (std::ptrdiff_t n = first; n < last; ++n) {
      s.frame[s.window_offset() + n] = signal[start + n] * s.window[n];
    }
    s.fft.forward(s.frame, result.frame(k));
  }
  return result;
}

std::vector<float> Stft::inverse(const Spectrogram& spectrogram, std::ptrdiff_t samples) {
  State& s = *state_;
  EARPOINT_CHECK(spectrogram.bins == bins() && spectrogram.frames == frames(samples));
  EARPOINT_CHECK(2 * s.shape.hop <= s.shape.window_size);
  std::vector<double> sum(samples);
  std::vector<double> weight(samples);
  for (int k = 0; k < spectrogram.frames; ++k) {
    s.fft.inverse(spectrogram.frame(k), s.frame);
    const std::ptrdiff_t start = s.window_start(k);
    const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, -start);
    const std::ptrdiff_t last = std::min<std::ptrdiff_t>(s.shape.window_size, samples - start);
    for (std::ptrdiff_t n = first; n < last; ++n) {
      const double w = s.window[n];
      sum[start + n] += w * s.frame[s.window_offset() + n];
      weight[start + n] += w * w;
    }
  }
  std::vector<float> signal(samples);
  for (std::ptrdiff_t n = 0; n < samples; ++n) {
    signal[n] = static_cast<float>(sum[n] / weight[n]);
  }
  return signal;
}

}  // namespace earpoint
