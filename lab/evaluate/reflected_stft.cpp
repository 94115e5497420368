#include "reflected_stft.h"

#include <cstddef>

#include <earpoint/error.h>

namespace earpoint {

PowerSpectrogram reflected_power(const StftShape& shape, std::span<const float> signal) {
  const std::ptrdiff_t half = shape.fft_size / 2;
  const std::ptrdiff_t samples = std::ssize(signal);
  EARPOINT_CHECK(samples > half);
  // Stft centres its frames at multiples of the hop: zeros before the mirror image bring the first
  // sample of the signal there.
  const std::ptrdiff_t zeros = (shape.hop - half % shape.hop) % shape.hop;
  std::vector<float> extended(static_cast<std::size_t>(zeros));
  extended.reserve(static_cast<std::size_t>(zeros + samples + 2 * half));
  for (std::ptrdiff_t n = half; n > 0; --n) extended.push_back(signal[n]);
  extended.insert(extended.end(), signal.begin(), signal.end());
  for (std::ptrdiff_t n = 0; n < half; ++n) extended.push_back(signal[samples - 2 - n]);

  Stft stft(shape);
  const Spectrogram all = stft.forward(extended);
  const auto first = static_cast<int>((zeros + half) / shape.hop);
  PowerSpectrogram result{stft.frames(samples), stft.bins(), {}};
  result.values.reserve(static_cast<std::size_t>(result.frames) * result.bins);
  for (int k = 0; k < result.frames; ++k) {
    for (const std::complex<float>& value : all.frame(first + k)) {
      result.values.push_back(std::norm(value));
    }
  }
  return result;
}

}  // namespace earpoint
