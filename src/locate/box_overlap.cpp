#include <earpoint/locate/box_overlap.h>

#include <algorithm>

namespace earpoint {
namespace {

double area(const Box& box) {
  return std::max(box.x_max - box.x_min, 0.0) * std::max(box.y_max - box.y_min, 0.0);
}

}  // namespace

double intersection_over_union(const Box& a, const Box& b) {
  const double shared = area({.x_min = std::max(a.x_min, b.x_min),
                              .y_min = std::max(a.y_min, b.y_min),
                              .x_max = std::min(a.x_max, b.x_max),
                              .y_max = std::min(a.y_max, b.y_max)});
  const double covered = area(a) + area(b) - shared;
  return covered > 0.0 ? shared / covered : 0.0;
}

std::vector<DetectedPerson> suppress_repeated(std::vector<DetectedPerson> people,
                                              double most_overlap) {
  std::ranges::stable_sort(people, std::ranges::greater{}, &DetectedPerson::score);
  std::vector<DetectedPerson> kept;
  for (const DetectedPerson& person : people) {
    const bool is_repeated = std::ranges::any_of(kept, [&](const DetectedPerson& surer) {
      return intersection_over_union(surer.box, person.box) > most_overlap;
    });
    if (!is_repeated) kept.push_back(person);
  }
  return kept;
}

}  // namespace earpoint
