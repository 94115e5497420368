#include <earpoint/people/view.h>

#include <algorithm>
#include <cmath>

#include <earpoint/core/area_mean.h>
#include <earpoint/error.h>
#include <earpoint/people/description.h>

namespace earpoint {
namespace {

int rounded_size(double pixels) {
  constexpr int kStep = PeopleDescription::kCoarsest;
  return kStep * std::max(1, static_cast<int>(std::lround(pixels / kStep)));
}

}  // namespace

ImagePlanes people_view(const Image& picture, int longest_px) {
  EARPOINT_CHECK(!picture.empty() && longest_px > 0);
  const double scale =
      static_cast<double>(longest_px) / std::max(picture.width(), picture.height());
  return people_view_of_part(picture, {.x_min = 0.0, .y_min = 0.0, .x_max = 1.0, .y_max = 1.0},
                             rounded_size(scale * picture.width()),
                             rounded_size(scale * picture.height()));
}

ImagePlanes people_view_of_part(const Image& picture, const Box& part, int width, int height) {
  EARPOINT_CHECK(!picture.empty() && picture.channels() == 3 && width > 0 && height > 0);
  ImagePlanes view{3, height, width, {}};
  view.values.resize(std::size_t{3} * height * width);
  const std::vector<Cover> columns = covers(picture.width(), width, part.x_min * picture.width(),
                                            (part.x_max - part.x_min) * picture.width());
  const std::vector<Cover> rows = covers(picture.height(), height, part.y_min * picture.height(),
                                         (part.y_max - part.y_min) * picture.height());
  area_means(picture, rows, columns, PeopleDescription::kMiddleGrey, view.values);
  for (float& value : view.values) value -= PeopleDescription::kMiddleGrey;
  return view;
}

}  // namespace earpoint
