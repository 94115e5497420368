#include "reference_stack.h"

#include <cmath>

#include <earpoint/core/random.h>

namespace earpoint::kernels {
namespace {

using Plane = std::vector<double>;

/// One row of a 1x1 convolution at one sample.
double row_at(std::span<const float> weight, std::span<const float> bias, std::size_t row,
              const std::vector<Plane>& planes, std::size_t t) {
  double sum = bias[row];
  for (std::size_t c = 0; c < planes.size(); ++c) {
    sum += weight[row * planes.size() + c] * planes[c][t];
  }
  return sum;
}

double dilated_at(const DilatedConvolution& convolution, std::span<const float> weight,
                  std::size_t row, const std::vector<Plane>& x, std::ptrdiff_t t) {
  double sum = 0.0;
  for (std::size_t c = 0; c < x.size(); ++c) {
    for (int j = 0; j < convolution.taps; ++j) {
      const std::ptrdiff_t at = t + (j - convolution.centre()) * convolution.dilation;
      if (at < 0 || at >= std::ssize(x[c])) continue;
      sum += weight[(row * x.size() + c) * convolution.taps + j] * x[c][at];
    }
  }
  return sum;
}

double dot(std::span<const float> weight, std::size_t row, std::span<const float> vector) {
  double sum = 0.0;
  for (std::size_t i = 0; i < vector.size(); ++i) {
    sum += static_cast<double>(weight[row * vector.size() + i]) * vector[i];
  }
  return sum;
}

}  // namespace

StackExample::StackExample(int audio_channels, int channels, int conditioning_width,
                           const std::vector<DilatedConvolution>& convolutions, std::uint64_t seed)
    : seed_(seed) {
  const auto audio = static_cast<std::size_t>(audio_channels);
  const auto width = static_cast<std::size_t>(channels);
  const auto z = static_cast<std::size_t>(conditioning_width);
  weights.audio_channels = audio_channels;
  weights.channels = channels;
  weights.conditioning_width = conditioning_width;
  weights.input_weight = draw(width * audio, 2.0);
  weights.input_bias = draw(width, 0.5);
  for (std::size_t i = 0; i < convolutions.size(); ++i) {
    GatedLayerWeights layer;
    layer.convolution = convolutions[i];
    const std::size_t kernel = width * width * convolutions[i].taps;
    const double most = 2.0 / std::sqrt(static_cast<double>(width * convolutions[i].taps));
    layer.filter_weight = draw(kernel, most);
    layer.filter_bias = draw(width, 0.2);
    layer.gate_weight = draw(kernel, most);
    layer.gate_bias = draw(width, 0.2);
    layer.filter_conditioning_weight = draw(width * z, 0.3);
    layer.filter_conditioning_bias = draw(width, 0.2);
    layer.gate_conditioning_weight = draw(width * z, 0.3);
    layer.gate_conditioning_bias = draw(width, 0.2);
    if (i + 1 < convolutions.size()) {
      layer.residual_weight = draw(width * width, 2.0 / std::sqrt(channels));
      layer.residual_bias = draw(width, 0.2);
    }
    layer.skip_weight = draw(width * width, 2.0 / std::sqrt(channels));
    layer.skip_bias = draw(width, 0.2);
    weights.layers.push_back(layer);
  }
  weights.first_weight = draw(width * width, 6.0 / std::sqrt(channels));
  weights.first_bias = draw(width, 0.2);
  weights.second_weight = draw(audio * width, 3.0 / std::sqrt(channels));
  weights.second_bias = draw(audio, 0.2);
}

std::span<const float> StackExample::draw(std::size_t size, double most) {
  RandomStream random(seed_++);
  std::vector<float> values(size);
  for (float& value : values) value = static_cast<float>(random.uniform(-most, most));
  return storage_.emplace_back(std::move(values));
}

std::vector<double> reference_stack(const GatedStackWeights& weights, std::span<const float> source,
                                    std::span<const float> conditioning) {
  const std::size_t samples = source.size() / weights.audio_channels;
  const auto channels = static_cast<std::size_t>(weights.channels);
  std::vector<Plane> waveform;
  for (int c = 0; c < weights.audio_channels; ++c) {
    const auto channel = source.subspan(c * samples, samples);
    waveform.emplace_back(channel.begin(), channel.end());
  }
  std::vector<Plane> x(channels, Plane(samples));
  for (std::size_t c = 0; c < channels; ++c) {
    for (std::size_t t = 0; t < samples; ++t) {
      x[c][t] = row_at(weights.input_weight, weights.input_bias, c, waveform, t);
    }
  }

  std::vector<Plane> mean(channels, Plane(samples));
  const double share = 1.0 / static_cast<double>(weights.layers.size());
  for (const GatedLayerWeights& layer : weights.layers) {
    std::vector<Plane> y(channels, Plane(samples));
    for (std::size_t c = 0; c < channels; ++c) {
      const double filter_constant = layer.filter_bias[c] + layer.filter_conditioning_bias[c] +
                                     dot(layer.filter_conditioning_weight, c, conditioning);
      const double gate_constant = layer.gate_bias[c] + layer.gate_conditioning_bias[c] +
                                   dot(layer.gate_conditioning_weight, c, conditioning);
      for (std::size_t t = 0; t < samples; ++t) {
        const double f =
            filter_constant + dilated_at(layer.convolution, layer.filter_weight, c, x, t);
        const double g = gate_constant + dilated_at(layer.convolution, layer.gate_weight, c, x, t);
        y[c][t] = std::sin(std::tanh(f) / (1.0 + std::exp(-g)));
      }
    }
    std::vector<Plane> next = x;
    for (std::size_t c = 0; c < channels; ++c) {
      for (std::size_t t = 0; t < samples; ++t) {
        mean[c][t] += share * row_at(layer.skip_weight, layer.skip_bias, c, y, t);
        if (layer.residual_weight.empty()) continue;
        next[c][t] = 0.5 * (row_at(layer.residual_weight, layer.residual_bias, c, y, t) + x[c][t]);
      }
    }
    x = std::move(next);
  }

  std::vector<Plane> first(channels, Plane(samples));
  for (std::size_t c = 0; c < channels; ++c) {
    for (std::size_t t = 0; t < samples; ++t) {
      first[c][t] = std::sin(row_at(weights.first_weight, weights.first_bias, c, mean, t));
    }
  }
  std::vector<double> output;
  for (int c = 0; c < weights.audio_channels; ++c) {
    for (std::size_t t = 0; t < samples; ++t) {
      output.push_back(row_at(weights.second_weight, weights.second_bias, c, first, t));
    }
  }
  return output;
}

}  // namespace earpoint::kernels
