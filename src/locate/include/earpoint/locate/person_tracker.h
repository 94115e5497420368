#pragma once

#include <memory>
#include <span>
#include <vector>

#include <earpoint/image.h>
#include <earpoint/locate/people_detector.h>

namespace earpoint {

/// A person in one picture, with the number that they keep from picture to picture.
struct TrackedPerson {
  int track = 0;        ///< counted from 0 in the order in which people appear
  Box box;              ///< filtered over time; while hidden, where they should be by their motion
  double score = 0.0;   ///< of the last detection
  bool is_seen = true;  ///< found in this very picture
};

/// Follows people from picture to picture.
///
/// A Kalman filter for the box's middle and size (each with a velocity) predicts where everyone
/// should be; detections are assigned to predictions by the Hungarian method on their intersection
/// over union. Whoever is not found is carried on by the prediction for 1.5 s, and is taken up
/// again when somebody of about the same size appears near it; then their number ends and is not
/// given again. A new person counts from the second picture in a row on that shows them, in the
/// first picture at once. Source: Bewley et al., "Simple online and realtime tracking" (ICIP 2016).
class PersonTracker {
 public:
  PersonTracker();
  ~PersonTracker();
  PersonTracker(PersonTracker&&) noexcept;
  PersonTracker& operator=(PersonTracker&&) noexcept;

  /// @param time_s  later than that of the picture before
  /// @param people  as PeopleDetector::detect() gives them
  /// @return        who is there, in the order of their numbers
  [[nodiscard]] std::vector<TrackedPerson> update(double time_s,
                                                  std::span<const DetectedPerson> people);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// How often a tracker changed its mind about who is who.
/// @param truth    [pictures][people] who is where, by numbers of their own
/// @param tracked  [pictures][people] what the tracker says
/// @return         how often a true person got another number than when they were last followed;
///                 somebody is followed by the track that overlaps them best, from an intersection
///                 over union of 0.5 on
[[nodiscard]] int count_identity_switches(std::span<const std::vector<TrackedPerson>> truth,
                                          std::span<const std::vector<TrackedPerson>> tracked);

}  // namespace earpoint
