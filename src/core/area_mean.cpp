#include <earpoint/core/area_mean.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace earpoint {
namespace {

float sum(std::span<const float> shares) {
  return std::accumulate(shares.begin(), shares.end(), 0.0F);
}

}  // namespace

std::vector<Cover> covers(int in, int out, double start, double width) {
  const double step = width / out;
  std::vector<Cover> found(static_cast<std::size_t>(out));
  for (int i = 0; i < out; ++i) {
    const double low = start + i * step;
    const double high = low + step;
    const int first = std::max(0, static_cast<int>(std::floor(low)));
    const int last = std::min(in, static_cast<int>(std::ceil(high)));
    found[i].first = first;
    for (int j = first; j < last; ++j) {
      const double overlap = std::min(high, j + 1.0) - std::max(low, static_cast<double>(j));
      found[i].shares.push_back(static_cast<float>(std::max(0.0, overlap) / step));
    }
  }
  return found;
}

// First along y, over whole rows of pixels, then along x.
void area_means(const Image& picture, std::span<const Cover> rows, std::span<const Cover> columns,
                float outside, std::span<float> planes) {
  const auto width = static_cast<std::size_t>(picture.width()) * 3;
  std::vector<float> mean_row(width);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::ranges::fill(mean_row, 0.0F);
    for (std::size_t y = 0; y < rows[i].shares.size(); ++y) {
      const std::uint8_t* pixels = picture.pixels().data() + (rows[i].first + y) * width;
      const float share = rows[i].shares[y];
      for (std::size_t x = 0; x < width; ++x) mean_row[x] += share * static_cast<float>(pixels[x]);
    }
    for (std::size_t j = 0; j < columns.size(); ++j) {
      std::array<float, 3> totals{};
      auto value = mean_row.begin() + std::ptrdiff_t{3} * columns[j].first;
      for (const float share : columns[j].shares) {
        for (float& total : totals) total += share * *value++;
      }
      const float bare = 1.0F - sum(rows[i].shares) * sum(columns[j].shares);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        planes[(channel * rows.size() + i) * columns.size() + j] =
            totals[channel] / 255.0F + bare * outside;
      }
    }
  }
}

}  // namespace earpoint
