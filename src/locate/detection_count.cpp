#include <earpoint/locate/detection_count.h>

#include <utility>
#include <vector>

#include <earpoint/locate/box_overlap.h>

namespace earpoint {

DetectionCount& DetectionCount::operator+=(const DetectionCount& other) {
  found += other.found;
  missed += other.missed;
  wrong += other.wrong;
  return *this;
}

double DetectionCount::recall() const {
  return found + missed == 0 ? 1.0 : static_cast<double>(found) / (found + missed);
}

double DetectionCount::precision() const {
  return found + wrong == 0 ? 1.0 : static_cast<double>(found) / (found + wrong);
}

DetectionCount count_detections(std::span<const DetectedPerson> found,
                                std::span<const TruePerson> people, double least_overlap) {
  DetectionCount count;
  std::vector<bool> is_taken(people.size());
  for (const DetectedPerson& detected : found) {
    std::pair<bool, double> best{false, 0.0};
    std::size_t whom = people.size();
    for (std::size_t i = 0; i < people.size(); ++i) {
      const double overlap = intersection_over_union(detected.box, people[i].box);
      const std::pair candidate{people[i].must_be_found, overlap};
      if (is_taken[i] || overlap < least_overlap || candidate <= best) continue;
      best = candidate;
      whom = i;
    }
    if (whom == people.size()) {
      ++count.wrong;
      continue;
    }
    is_taken[whom] = true;
    count.found += people[whom].must_be_found ? 1 : 0;
  }
  for (std::size_t i = 0; i < people.size(); ++i) {
    count.missed += people[i].must_be_found && !is_taken[i] ? 1 : 0;
  }
  return count;
}

}  // namespace earpoint
