#include <earpoint/locate/decode_people.h>

#include <algorithm>
#include <cmath>

#include <earpoint/error.h>
#include <earpoint/locate/box_overlap.h>
#include <earpoint/people/description.h>

namespace earpoint {
namespace {

using D = PeopleDescription;

// Boxes of two people rarely overlap as much.
constexpr double kMostOverlap = 0.55;

bool is_surest(std::span<const float> sure, int rows, int columns, int row, int column) {
  const float here = sure[static_cast<std::size_t>(row) * columns + column];
  for (int y = std::max(0, row - 1); y <= std::min(rows - 1, row + 1); ++y) {
    for (int x = std::max(0, column - 1); x <= std::min(columns - 1, column + 1); ++x) {
      if (sure[static_cast<std::size_t>(y) * columns + x] > here) return false;
    }
  }
  return true;
}

}  // namespace

std::vector<DetectedPerson> decode_people(std::span<const float> map, int rows, int columns,
                                          double least_score) {
  const std::size_t cells = static_cast<std::size_t>(rows) * columns;
  EARPOINT_CHECK(rows > 0 && columns > 0 && map.size() == D::kOutputs * cells);
  const std::span<const float> sure = map.first(cells);
  std::vector<DetectedPerson> people;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const std::size_t cell = static_cast<std::size_t>(row) * columns + column;
      const double score = 1.0 / (1.0 + std::exp(-static_cast<double>(sure[cell])));
      // Not written as score < least_score, so that NaN is no person.
      if (!(score >= least_score) || !is_surest(sure, rows, columns, row, column)) continue;
      const auto output = [&](std::size_t number) { return map[number * cells + cell]; };
      const auto half = [&](std::size_t number) {
        return 0.5 * D::kBoxUnit *
               std::exp(std::clamp(output(number), -D::kLargestLog, D::kLargestLog)) / D::kCell;
      };
      const double x = column + 0.5 + output(1);
      const double y = row + 0.5 + output(2);
      const double half_width = half(3);
      const double half_height = half(4);
      const Box box{.x_min = std::clamp((x - half_width) / columns, 0.0, 1.0),
                    .y_min = std::clamp((y - half_height) / rows, 0.0, 1.0),
                    .x_max = std::clamp((x + half_width) / columns, 0.0, 1.0),
                    .y_max = std::clamp((y + half_height) / rows, 0.0, 1.0)};
      if (box.x_min < box.x_max && box.y_min < box.y_max) people.push_back({box, score});
    }
  }
  return suppress_repeated(std::move(people), kMostOverlap);
}

}  // namespace earpoint
