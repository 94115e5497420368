#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>

#include <earpoint/core/error.h>
#include <earpoint/core/pose.h>
#include <earpoint/model/gtf_view.h>

namespace earpoint {
namespace {

constexpr float kGrey = 0.5F;

/// The pixels along one axis that an output covers, each with its share of the output.
struct Cover {
  int first = 0;
  std::vector<float> shares;
};

/// @param in     pixels of the picture along this axis
/// @param out    pixels of the view
/// @param width  of the view in the picture's pixels; both have the same middle
std::vector<Cover> covers(int in, int out, double width) {
  const double start = 0.5 * (in - width);
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

float sum(std::span<const float> shares) {
  return std::accumulate(shares.begin(), shares.end(), 0.0F);
}

/// Means over the areas where rows and columns cross; what of them lies outside of the picture is
/// grey. First along y, over whole rows of pixels, then along x.
/// @param view  [3][rows][columns], in [0, 1]
void shrink(const Image& picture, const std::vector<Cover>& rows, const std::vector<Cover>& columns,
            std::span<float> view) {
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
        view[(channel * rows.size() + i) * columns.size() + j] =
            totals[channel] / 255.0F + bare * kGrey;
      }
    }
  }
}

}  // namespace

GtfView gtf_view(const Image* picture, const std::optional<Box>& speaker_box,
                 double horizontal_fov_rad, int size) {
  EARPOINT_CHECK(size > 0 && horizontal_fov_rad > 0 && horizontal_fov_rad < kPi);
  GtfView view;
  view.picture.assign(static_cast<std::size_t>(3) * size * size, kGrey);
  // Half the picture's width at a distance of 1; the view's is 1.
  const double half_width = std::tan(0.5 * horizontal_fov_rad);
  double aspect = 1.0;
  if (picture != nullptr) {
    EARPOINT_CHECK(picture->channels() == 3 && !picture->empty());
    const double width = picture->width() / half_width;
    const std::vector<Cover> columns = covers(picture->width(), size, width);
    const std::vector<Cover> rows = covers(picture->height(), size, width);
    shrink(*picture, rows, columns, view.picture);
    aspect = static_cast<double>(picture->height()) / picture->width();
  }
  if (speaker_box) {
    const auto within = [](double value, double scale) {
      return std::clamp(0.5 + (value - 0.5) * scale, 0.0, 1.0);
    };
    const Box box{.x_min = within(speaker_box->x_min, half_width),
                  .y_min = within(speaker_box->y_min, half_width * aspect),
                  .x_max = within(speaker_box->x_max, half_width),
                  .y_max = within(speaker_box->y_max, half_width * aspect)};
    if (box.x_min < box.x_max && box.y_min < box.y_max) view.speaker_box = box;
  }
  return view;
}

}  // namespace earpoint
