#include "picture_encoder.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <earpoint/error.h>
#include <earpoint/gtf/constants.h>
#include <earpoint/gtf/description.h>
#include <earpoint/kernels/dense.h>
#include <earpoint/kernels/norms.h>

namespace earpoint::gtf {
namespace {

using D = GtfDescription;

constexpr int kTaps = 9;  // of a 3x3 kernel

/// [out][in][3][3] -> [out][3][3][in].
std::vector<float> channels_last(std::span<const float> weight, int out, int in) {
  std::vector<float> result(weight.size());
  for (int o = 0; o < out; ++o) {
    for (int i = 0; i < in; ++i) {
      for (int tap = 0; tap < kTaps; ++tap) {
        result[(o * kTaps + tap) * in + i] = weight[(o * in + i) * kTaps + tap];
      }
    }
  }
  return result;
}

/// Groups of channels to mean zero and variance one, scaled and shifted; then SiLU.
void normalize(std::span<float> map, int channels, const std::vector<float>& scale,
               const std::vector<float>& shift) {
  const int of_group = channels / D::kNormGroups;
  const std::size_t pixels = map.size() / static_cast<std::size_t>(channels);
  for (int group = 0; group < D::kNormGroups; ++group) {
    double sum = 0.0;
    double squares = 0.0;
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
      for (int c = group * of_group; c < (group + 1) * of_group; ++c) {
        const double value = map[pixel * channels + c];
        sum += value;
        squares += value * value;
      }
    }
    const double count = static_cast<double>(pixels) * of_group;
    const double mean = sum / count;
    const double factor =
        1.0 / std::sqrt(squares / count - mean * mean + kernels::kGroupNormEpsilon);
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
      for (int c = group * of_group; c < (group + 1) * of_group; ++c) {
        float& value = map[pixel * channels + c];
        value = static_cast<float>((value - mean) * factor) * scale[c] + shift[c];
      }
    }
  }
  kernels::silu(map);
}

}  // namespace

kernels::Dense dense_of(const GtfWeights& weights, const std::string& name) {
  return {weights.at(name + ".weight").as<float>(), weights.at(name + ".bias").as<float>()};
}

GtfPictureEncoder::GtfPictureEncoder(const GtfWeights& weights)
    : size_(weights.description.picture_px), output_(dense_of(weights, "picture.output")) {
  EARPOINT_CHECK(size_ > 0);
  std::size_t columns = 0;
  std::size_t rows = 0;
  std::size_t map = static_cast<std::size_t>(D::kPictureChannels[0]) * size_ * size_;
  for (int i = 0; i < D::kPictureLayers; ++i) {
    const std::string name = fmt::format("picture.{}", i);
    const auto values = [&](const char* part) { return weights.at(name + part).as<float>(); };
    const int in = D::kPictureChannels[i];
    const int out = D::kPictureChannels[i + 1];
    Layer layer{in,
                size_ >> i,
                {channels_last(values(".weight"), out, in), out},
                kernels::padded_row(values(".bias")),
                {},
                {}};
    const auto scale = values(".norm.weight");
    const auto shift = values(".norm.bias");
    layer.norm_scale.assign(scale.begin(), scale.end());
    layer.norm_shift.assign(shift.begin(), shift.end());
    const std::size_t pixels = static_cast<std::size_t>(size_ >> (i + 1)) * (size_ >> (i + 1));
    columns = std::max(columns, pixels * kTaps * in);
    rows = std::max(rows, pixels * static_cast<std::size_t>(layer.weight.row()));
    map = std::max(map, pixels * out);
    layers_.push_back(std::move(layer));
  }
  columns_.resize(columns);
  rows_.resize(rows);
  map_.resize(map);
  flat_.resize(static_cast<std::size_t>(output_.inputs()));
  if (weights.description.sight_points == 0) return;
  sight_ = dense_of(weights, "sight");
  places_.resize(std::size_t{2} * weights.description.sight_points);
  there_.resize(static_cast<std::size_t>(sight_->inputs()));
  const int side = size_ >> D::kSightLayer;
  sight_map_.resize(there_.size() * side * side);
}

void GtfPictureEncoder::convolve(const Layer& layer) {
  const int in = layer.channels_in;
  const int side = layer.side_in / 2;
  float* column = columns_.data();
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      for (int tap = 0; tap < kTaps; ++tap) {
        const int from_y = 2 * y - 1 + tap / 3;
        const int from_x = 2 * x - 1 + tap % 3;
        // Taps leave the map only at the top and left, as the side is even.
        if (from_y < 0 || from_x < 0) {
          column = std::fill_n(column, in, 0.0F);
        } else {
          column = std::copy_n(map_.data() + std::ptrdiff_t{from_y * layer.side_in + from_x} * in,
                               in, column);
        }
      }
    }
  }
  const std::ptrdiff_t pixels = std::ptrdiff_t{side} * side;
  const std::ptrdiff_t out = layer.weight.outputs();
  layer.weight.multiply(columns_.data(), std::ptrdiff_t{kTaps} * in, pixels, layer.bias.data(),
                        rows_.data(), false);
  for (std::ptrdiff_t pixel = 0; pixel < pixels; ++pixel) {
    std::copy_n(rows_.data() + pixel * layer.weight.row(), out, map_.data() + pixel * out);
  }
  normalize(std::span(map_).first(static_cast<std::size_t>(pixels * out)), static_cast<int>(out),
            layer.norm_scale, layer.norm_shift);
}

void GtfPictureEncoder::encode(std::span<const float> picture, const std::optional<Box>& box,
                               std::span<float> feature) {
  const std::size_t pixels = static_cast<std::size_t>(size_) * size_;
  EARPOINT_CHECK(picture.size() == 3 * pixels && std::ssize(feature) == output_.outputs());
  for (int y = 0; y < size_; ++y) {
    for (int x = 0; x < size_; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * size_ + x;
      for (std::size_t c = 0; c < 3; ++c)
        map_[4 * pixel + c] = picture[c * pixels + pixel] - gtf::kMiddleGrey;
      const float across = (static_cast<float>(x) + 0.5F) / static_cast<float>(size_);
      const float down = (static_cast<float>(y) + 0.5F) / static_cast<float>(size_);
      const bool is_inside = box && across >= static_cast<float>(box->x_min) &&
                             across <= static_cast<float>(box->x_max) &&
                             down >= static_cast<float>(box->y_min) &&
                             down <= static_cast<float>(box->y_max);
      map_[4 * pixel + 3] = is_inside ? 1.0F : 0.0F;
    }
  }
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    convolve(layers_[i]);
    if (i + 1 == D::kSightLayer) std::copy_n(map_.begin(), sight_map_.size(), sight_map_.begin());
  }
  const std::size_t channels = D::kPictureChannels[D::kPictureLayers];
  const std::size_t places = flat_.size() / channels;
  for (std::size_t place = 0; place < places; ++place) {
    for (std::size_t c = 0; c < channels; ++c)
      flat_[c * places + place] = map_[place * channels + c];
  }
  output_.apply(flat_, feature);
  kernels::silu(feature);
}

void GtfPictureEncoder::encode_towards(const Vector3& target_m, std::span<float> sight) {
  EARPOINT_CHECK(sight_.has_value());
  EARPOINT_CHECK(sight.size() == places_.size() * (D::kSightWidth + 1));
  find_sights(target_m, size_ >> D::kSightLayer, places_);
  for (const GtfSight& place : places_) {
    const std::span<float> seen = sight.first(D::kSightWidth);
    std::ranges::fill(seen, 0.0F);
    if (place.is_seen) {
      std::ranges::fill(there_, 0.0F);
      for (std::size_t i = 0; i < place.pixels.size(); ++i) {
        const float* pixel = sight_map_.data() + place.pixels[i] * std::ssize(there_);
        for (std::size_t c = 0; c < there_.size(); ++c) there_[c] += place.weights[i] * pixel[c];
      }
      sight_->apply(there_, seen);
      kernels::silu(seen);
    }
    sight[D::kSightWidth] = place.is_seen ? 1.0F : 0.0F;
    sight = sight.subspan(D::kSightWidth + 1);
  }
}

}  // namespace earpoint::gtf
