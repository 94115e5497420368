#pragma once

#include <span>

#include <earpoint/locate/people_detector.h>

namespace earpoint {

/// A person who is truly in a picture.
struct TruePerson {
  Box box;
  bool must_be_found = true;  ///< else finding is neither right nor wrong, and missing is no miss
};

/// How many people a detector found, missed and made up.
struct DetectionCount {
  int found = 0;
  int missed = 0;
  int wrong = 0;

  DetectionCount& operator+=(const DetectionCount& other);
  /// Share of people that were found; 1 if there were none.
  [[nodiscard]] double recall() const;
  /// Share of what was found that is people; 1 if nothing was found.
  [[nodiscard]] double precision() const;
};

/// Compares what a detector found in one picture with who is there: the surest first, each takes
/// the person not yet taken whose box it overlaps most, those who must be found before others.
/// @param found          the surest first
/// @param least_overlap  intersection over union that makes two boxes the same person
[[nodiscard]] DetectionCount count_detections(std::span<const DetectedPerson> found,
                                              std::span<const TruePerson> people,
                                              double least_overlap = 0.5);

}  // namespace earpoint
