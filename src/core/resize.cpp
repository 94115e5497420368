#include <earpoint/core/resize.h>

#include <algorithm>

#include <earpoint/error.h>

namespace earpoint {
namespace {

/// Between which two inputs an output lies along one axis, and how near to the second.
struct Between {
  int lower = 0;
  int upper = 0;
  float fraction = 0.0F;
};

std::vector<Between> positions(int in, int out) {
  std::vector<Between> result;
  const float scale = static_cast<float>(in) / static_cast<float>(out);
  for (int i = 0; i < out; ++i) {
    const float at = std::max(0.0F, (static_cast<float>(i) + 0.5F) * scale - 0.5F);
    const int lower = std::min(static_cast<int>(at), in - 1);
    result.push_back({lower, std::min(lower + 1, in - 1), at - static_cast<float>(lower)});
  }
  return result;
}

}  // namespace

ImagePlanes planes_of(const Image& image) {
  ImagePlanes planes{image.channels(), image.height(), image.width(), {}};
  planes.values.reserve(image.pixels().size());
  for (int c = 0; c < image.channels(); ++c) {
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        planes.values.push_back(static_cast<float>(image.at(x, y, c)));
      }
    }
  }
  return planes;
}

ImagePlanes resize_bilinear(const ImagePlanes& planes, int width, int height) {
  EARPOINT_CHECK(width > 0 && height > 0 && planes.width > 0 && planes.height > 0);
  if (planes.width == width && planes.height == height) return planes;
  const std::vector<Between> columns = positions(planes.width, width);
  const std::vector<Between> rows = positions(planes.height, height);
  ImagePlanes result{planes.channels, height, width, {}};
  result.values.reserve(static_cast<std::size_t>(planes.channels) * height * width);
  for (int c = 0; c < planes.channels; ++c) {
    const auto row_of = [&](int y) {
      return planes.values.data() +
             (static_cast<std::size_t>(c) * planes.height + y) * planes.width;
    };
    for (const Between& row : rows) {
      const float* above = row_of(row.lower);
      const float* below = row_of(row.upper);
      for (const Between& column : columns) {
        const float fx = column.fraction;
        const float top = (1.0F - fx) * above[column.lower] + fx * above[column.upper];
        const float bottom = (1.0F - fx) * below[column.lower] + fx * below[column.upper];
        result.values.push_back((1.0F - row.fraction) * top + row.fraction * bottom);
      }
    }
  }
  return result;
}

}  // namespace earpoint
