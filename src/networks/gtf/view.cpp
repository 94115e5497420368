#include <earpoint/gtf/view.h>

#include <algorithm>
#include <cmath>

#include <earpoint/core/area_mean.h>
#include <earpoint/error.h>
#include <earpoint/gtf/constants.h>
#include <earpoint/pose.h>

namespace earpoint {

GtfView gtf_view(const Image* picture, const std::optional<Box>& speaker_box,
                 double horizontal_fov_rad, int size) {
  EARPOINT_CHECK(size > 0 && horizontal_fov_rad > 0 && horizontal_fov_rad < kPi);
  GtfView view;
  view.picture.assign(static_cast<std::size_t>(3) * size * size, gtf::kMiddleGrey);
  // Half the picture's width at a distance of 1; the view's is 1.
  const double half_width = std::tan(0.5 * horizontal_fov_rad);
  double aspect = 1.0;
  if (picture != nullptr) {
    EARPOINT_CHECK(picture->channels() == 3 && !picture->empty());
    const double width = picture->width() / half_width;
    const auto middle = [&](int pixels) {
      return covers(pixels, size, 0.5 * (pixels - width), width);
    };
    area_means(*picture, middle(picture->height()), middle(picture->width()), gtf::kMiddleGrey,
               view.picture);
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
