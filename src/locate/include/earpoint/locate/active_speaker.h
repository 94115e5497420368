#pragma once

#include <span>
#include <vector>

#include <earpoint/image.h>
#include <earpoint/locate/person_tracker.h>
#include <earpoint/locate/voice_direction.h>

namespace earpoint {

/// Where in the horizontal plane somebody in a picture is, and how well a box tells it.
struct BoxDirection {
  double azimuth_rad = 0.0;  ///< of the box's middle
  double spread_rad = 0.0;   ///< standard deviation of the mouth from there
};

/// @param horizontal_fov_rad  of the whole picture, in (0, pi)
[[nodiscard]] BoxDirection direction_of_box(const Box& box, double horizontal_fov_rad);

/// What is known of one moment before it is decided who speaks.
struct SpeakerMoment {
  std::vector<int> tracks;          ///< who is in the picture
  std::vector<double> likelihoods;  ///< of the sound if each of them speaks; up to a factor
  double outside = 1.0;             ///< the same if somebody speaks who is not in the picture
  double power = 0.0;               ///< of the sound
};

/// @param people              who is in the picture
/// @param horizontal_fov_rad  of the whole picture
[[nodiscard]] SpeakerMoment speaker_moment(std::span<const TrackedPerson> people,
                                           const DirectionEvidence& evidence,
                                           double horizontal_fov_rad);

/// Who speaks at one moment, as probabilities that add up to one.
struct SpeakerBelief {
  std::vector<double> people;  ///< as SpeakerMoment::tracks has them
  double outside = 1.0;        ///< somebody who is not in the picture
  /// Whether anybody speaks: 0 to 1, by the level against the loud moments of the recording. The
  /// others are probabilities of who speaks if somebody does.
  double voice = 0.0;
};

/// Decides who speaks at every moment of a recording, by all moments before and after it.
///
/// A hidden Markov model: one person speaks at a time, and goes on for 4 s on average; evidence of
/// all moments is joined by the forward-backward algorithm. Before anything is heard, somebody
/// outside the picture is taken to be the speaker with a probability of 0.1, or of 1 where the
/// picture shows nobody. Somebody whose track ends goes on as somebody outside.
/// @param moments  every 0.2 s
/// Source: Rabiner, Proc. IEEE 77 (1989).
[[nodiscard]] std::vector<SpeakerBelief> active_speakers(std::span<const SpeakerMoment> moments);

}  // namespace earpoint
