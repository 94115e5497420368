#include <earpoint/kernels/strided.h>

#include <algorithm>
#include <cstddef>

#include <earpoint/error.h>
#include <earpoint/kernels/matrix.h>

namespace earpoint::kernels {

std::vector<float> convolve_strided(std::span<const float> in, int inputs,
                                    std::span<const float> weight, std::span<const float> bias,
                                    StridedShape shape) {
  const std::ptrdiff_t samples = std::ssize(in) / inputs;
  const std::ptrdiff_t length = samples / shape.stride;
  EARPOINT_CHECK(length * shape.stride == samples);
  const int taps = shape.taps();
  // Rows are the taps of all inputs, columns the outputs' places.
  std::vector<float> columns(static_cast<std::size_t>(std::ptrdiff_t{inputs} * taps * length));
  for (int row = 0; row < inputs * taps; ++row) {
    const float* channel = in.data() + row / taps * samples;
    const std::ptrdiff_t offset = row % taps - shape.padding;
    for (std::ptrdiff_t t = 0; t < length; ++t) {
      const std::ptrdiff_t at = t * shape.stride + offset;
      if (at >= 0 && at < samples) columns[row * length + t] = channel[at];
    }
  }
  std::vector<float> out(bias.size() * static_cast<std::size_t>(length));
  for (std::size_t c = 0; c < bias.size(); ++c) {
    std::fill_n(out.begin() + static_cast<std::ptrdiff_t>(c) * length, length, bias[c]);
  }
  multiply(weight, columns, out, static_cast<int>(bias.size()), inputs * taps,
           static_cast<int>(length), /*add=*/true);
  return out;
}

std::vector<float> convolve_transposed(std::span<const float> in, int inputs,
                                       std::span<const float> weight, std::span<const float> bias,
                                       StridedShape shape) {
  const std::ptrdiff_t length = std::ssize(in) / inputs;
  const std::ptrdiff_t samples = length * shape.stride;
  const int taps = shape.taps();
  const int rows = static_cast<int>(bias.size()) * taps;
  std::vector<float> columns(static_cast<std::size_t>(rows * length));
  transposed_multiply(weight, in, columns, rows, inputs, static_cast<int>(length));
  std::vector<float> out(bias.size() * static_cast<std::size_t>(samples));
  for (std::size_t c = 0; c < bias.size(); ++c) {
    std::fill_n(out.begin() + static_cast<std::ptrdiff_t>(c) * samples, samples, bias[c]);
  }
  for (int row = 0; row < rows; ++row) {
    float* channel = out.data() + row / taps * samples;
    const std::ptrdiff_t offset = row % taps - shape.padding;
    for (std::ptrdiff_t t = 0; t < length; ++t) {
      const std::ptrdiff_t at = t * shape.stride + offset;
      if (at >= 0 && at < samples) channel[at] += columns[row * length + t];
    }
  }
  return out;
}

}  // namespace earpoint::kernels
