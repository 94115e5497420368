#pragma once

#include <vector>

#include <earpoint/image.h>
#include <earpoint/locate/people_detector.h>

namespace earpoint {

/// Area that two boxes share over the area that they cover together, 0 to 1; 0 for boxes without
/// area.
[[nodiscard]] double intersection_over_union(const Box& a, const Box& b);

/// Keeps the surest of those boxes that show the same person: greedy non-maximum suppression.
/// @param most_overlap  boxes that overlap a surer one by more (intersection over union) are
///                      dropped
/// @return the rest, the surest first; equal scores stay in the order given
[[nodiscard]] std::vector<DetectedPerson> suppress_repeated(std::vector<DetectedPerson> people,
                                                            double most_overlap);

}  // namespace earpoint
