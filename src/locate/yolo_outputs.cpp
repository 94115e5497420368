#include "yolo_outputs.h"

#include <array>
#include <cmath>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr std::array kSteps{8, 16, 32};

DetectedPerson person_at(double x, double y, double width, double height, double score) {
  return {{.x_min = x - 0.5 * width,
           .y_min = y - 0.5 * height,
           .x_max = x + 0.5 * width,
           .y_max = y + 0.5 * height},
          score};
}

std::vector<DetectedPerson> yolov8_people(std::span<const float> output, std::size_t places,
                                          double least_score) {
  std::vector<DetectedPerson> people;
  for (std::size_t i = 0; i < places; ++i) {
    const auto row = [&](std::size_t number) { return output[number * places + i]; };
    // Not written as score < least_score, so that NaN is no person.
    if (row(4) >= least_score) people.push_back(person_at(row(0), row(1), row(2), row(3), row(4)));
  }
  return people;
}

std::vector<DetectedPerson> yolox_people(std::span<const float> output, std::size_t places,
                                         int height, int width, double least_score) {
  std::vector<DetectedPerson> people;
  const std::size_t numbers = output.size() / places;
  const float* place = output.data();
  for (const int step : kSteps) {
    for (int row = 0; row < height / step; ++row) {
      for (int column = 0; column < width / step; ++column, place += numbers) {
        const double score = static_cast<double>(place[4]) * place[5];
        if (!(score >= least_score)) continue;
        people.push_back(
            person_at((column + double{place[0]}) * step, (row + double{place[1]}) * step,
                      std::exp(double{place[2]}) * step, std::exp(double{place[3]}) * step, score));
      }
    }
  }
  return people;
}

}  // namespace

int yolo_places(int height, int width) {
  int places = 0;
  for (const int step : kSteps) places += (height / step) * (width / step);
  return places;
}

std::vector<DetectedPerson> yolo_people(std::span<const float> output, YoloLayout layout,
                                        int places, int height, int width, double least_score) {
  const auto count = static_cast<std::size_t>(places);
  const std::size_t least = layout == YoloLayout::yolov8 ? 5 : 6;
  EARPOINT_CHECK(places == yolo_places(height, width) && places > 0 &&
                 output.size() >= least * count && output.size() % count == 0);
  return layout == YoloLayout::yolov8 ? yolov8_people(output, count, least_score)
                                      : yolox_people(output, count, height, width, least_score);
}

}  // namespace earpoint
