#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <earpoint/error.h>

namespace earpoint {

/// Pixels in memory, row-major and interleaved: [height][width][channels], top row first.
template <typename T>
class Raster {
 public:
  Raster() = default;
  Raster(int width, int height, int channels, T fill = T{})
      : width_(width), height_(height), channels_(channels) {
    EARPOINT_CHECK(width >= 0 && height >= 0 && channels >= 0);
    data_.assign(static_cast<std::size_t>(width) * height * channels, fill);
  }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] int channels() const { return channels_; }
  [[nodiscard]] bool empty() const { return data_.empty(); }

  [[nodiscard]] T& at(int x, int y, int channel = 0) { return data_[index(x, y, channel)]; }
  [[nodiscard]] const T& at(int x, int y, int channel = 0) const {
    return data_[index(x, y, channel)];
  }
  [[nodiscard]] std::span<T> pixels() { return data_; }
  [[nodiscard]] std::span<const T> pixels() const { return data_; }

 private:
  [[nodiscard]] std::size_t index(int x, int y, int channel) const {
    EARPOINT_DCHECK(x >= 0 && x < width_ && y >= 0 && y < height_);
    EARPOINT_DCHECK(channel >= 0 && channel < channels_);
    return (static_cast<std::size_t>(y) * width_ + x) * channels_ + channel;
  }

  int width_ = 0;
  int height_ = 0;
  int channels_ = 0;
  std::vector<T> data_;
};

/// A picture: 8 bits per channel, sRGB, three channels unless a name says otherwise.
using Image = Raster<std::uint8_t>;
/// Depth in metres, linear light, and the like.
using FloatImage = Raster<float>;

/// A rectangle in a picture, normalised: x grows to the right, y downwards, both in [0, 1].
struct Box {
  double x_min = 0.0;
  double y_min = 0.0;
  double x_max = 0.0;
  double y_max = 0.0;

  friend constexpr bool operator==(const Box&, const Box&) = default;
};

}  // namespace earpoint
