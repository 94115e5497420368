#pragma once

#include <span>
#include <vector>

#include <earpoint/locate/people_detector.h>

namespace earpoint {

/// A detector keeps people of whom it is at least that sure.
inline constexpr double kLeastPersonScore = 0.35;

/// Reads the people out of the map that the network of PeopleDescription gives: every cell that is
/// surer than its eight neighbours and than `least_score` is the middle of a person; of boxes that
/// show the same person the surest stays.
/// @param map      [PeopleDescription::kOutputs][rows][columns]
/// @return boxes cut at the picture's edges, the surest first
[[nodiscard]] std::vector<DetectedPerson> decode_people(std::span<const float> map, int rows,
                                                        int columns,
                                                        double least_score = kLeastPersonScore);

}  // namespace earpoint
