#include "trunk.h"

#include "picture_encoder.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <earpoint/kernels/dense.h>

namespace earpoint::gtf {
namespace {

/// One tap of [out][in][3] as [out][in].
std::vector<float> tap_of(std::span<const float> weight, std::size_t tap) {
  std::vector<float> matrix(weight.size() / gtf::kTrunkTaps);
  for (std::size_t i = 0; i < matrix.size(); ++i) matrix[i] = weight[gtf::kTrunkTaps * i + tap];
  return matrix;
}

}  // namespace

GtfTrunk::GtfTrunk(const GtfWeights& weights, std::ptrdiff_t most_frames)
    : channels_(weights.description.channels),
      inputs_(weights.description.frame_features()),
      input_(weights.at("trunk.input.weight").as<float>(), channels_),
      input_bias_(kernels::padded_row(weights.at("trunk.input.bias").as<float>())),
      sums_(most_frames * row()) {
  for (int i = 0; i < weights.description.layers; ++i) {
    const std::string name = fmt::format("trunk.{}", i);
    const auto values = weights.at(name + ".weight").as<float>();
    Layer layer;
    layer.step = weights.description.dilation(i);
    for (std::size_t tap = 0; tap < gtf::kTrunkTaps; ++tap) {
      layer.taps[tap] = kernels::FrameMatrix(tap_of(values, tap), channels_);
    }
    layer.bias = kernels::padded_row(weights.at(name + ".bias").as<float>());
    layer.film = dense_of(weights, name + ".film");
    layer.scale_and_shift.resize(static_cast<std::size_t>(2 * channels_));
    layer.memory = AlignedFloats((2 * layer.step + most_frames) * row());
    layers_.push_back(std::move(layer));
  }
}

void GtfTrunk::reset() {
  for (Layer& layer : layers_) {
    std::fill_n(layer.memory.data(), layer.memory.size(), 0.0F);
  }
}

void GtfTrunk::condition(std::span<const float> conditions) {
  for (Layer& layer : layers_) layer.film.apply(conditions, layer.scale_and_shift);
}

void GtfTrunk::run(const float* features, std::ptrdiff_t frames, float* states) {
  input_.multiply(features, inputs_, frames, input_bias_.data(), states, false);
  for (std::ptrdiff_t f = 0; f < frames; ++f) {
    kernels::silu({states + f * row(), static_cast<std::size_t>(channels_)});
  }
  for (Layer& layer : layers_) {
    const std::ptrdiff_t past = 2 * layer.step * row();
    float* memory = layer.memory.data();
    std::copy_n(states, frames * row(), memory + past);
    for (std::ptrdiff_t tap = 0; tap < gtf::kTrunkTaps; ++tap) {
      layer.taps[tap].multiply(memory + tap * layer.step * row(), row(), frames, layer.bias.data(),
                               sums_.data(), tap > 0);
    }
    const float* scale = layer.scale_and_shift.data();
    const float* shift = scale + channels_;
    for (std::ptrdiff_t f = 0; f < frames; ++f) {
      const float* sum = sums_.data() + f * row();
      float* state = states + f * row();
      for (std::ptrdiff_t c = 0; c < channels_; ++c) {
        const float y = sum[c] * (1.0F + scale[c]) + shift[c];
        state[c] += y / (1.0F + std::exp(-y));
      }
    }
    std::copy(memory + frames * row(), memory + frames * row() + past, memory);
  }
}

}  // namespace earpoint::gtf
