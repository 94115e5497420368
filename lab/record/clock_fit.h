#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <earpoint/pose.h>
#include <earpoint/record/session_truth.h>

namespace earpoint {

inline constexpr double kSoundMetresPerSecond = 343.0;

/// When an ear of a camera may have heard the sound of an event.
struct HeardTime {
  double device_s = 0.0;  ///< on the camera's clock
  double height = 1.0;    ///< of its correlation peak, over the highest
};

/// What one ear heard of an event: the direct sound is one of the times, if any.
struct HeardEvent {
  std::size_t device = 0;  ///< a camera
  int ear = 0;
  double expected_s = 0.0;  ///< about when, on the camera's clock
  std::vector<HeardTime> times;
};

/// A stretch of speech, heard by everyone: its moment is known on the clock of one device, the near
/// microphone of who spoke or, without microphones, a camera.
struct SoundEvent {
  std::size_t anchor = 0;         ///< a device
  std::optional<int> anchor_ear;  ///< of a camera; nothing: a near microphone
  double anchor_s = 0.0;          ///< on its clock
  std::vector<HeardEvent> heard;
};

/// When a camera heard the clapper, whose place is known, less the way from there: the same moment
/// for all of them. Cauchy's weights leave out a camera that heard a reflection.
struct ClapTime {
  std::size_t device = 0;
  double device_s = 0.0;  ///< when it clapped, on the camera's clock
};

/// A device of the fit.
struct FitDevice {
  DeviceClock clock;                    ///< to begin with, good to some milliseconds
  std::optional<Pose> world_from_head;  ///< of calibrated cameras
  double near_distance_m = 0.0;         ///< of near microphones
  double middle_s = 0.0;                ///< of its recording, on its clock
};

struct ClockFit {
  std::vector<DeviceClock> clocks;
  std::vector<Vector3> positions;  ///< of each event's source
  /// One standard deviation of each clock's offset in the middle of the recording, seconds.
  std::vector<double> deviations_s;
  /// By event and HeardEvent: what is left of the chosen time, seconds; nothing where none fits.
  std::vector<std::vector<std::optional<double>>> residuals_s;
};

/// Finds clocks and places of sources together, so that the times at which sounds are heard, less
/// the ways that they travel, agree: nonlinear least squares with Cauchy's weights, whose width
/// shrinks from 2 ms to 0.06 ms. Places are eliminated from the normal equations seat by seat
/// (Schur's complement): a voice that stays where it is has one place.
/// @param devices    the first is the reference, whose clock stays; all cameras calibrated
/// @param claps      of cameras that heard it directly; any number. From three on, no clock is left
///                   where its clap is more than 2 ms from the median of all
/// @param places_m   of each event's source, to begin with; good to some decimetres
/// @param centre_m   about where people are
[[nodiscard]] ClockFit fit_clocks(const std::vector<FitDevice>& devices,
                                  const std::vector<SoundEvent>& events,
                                  const std::vector<ClapTime>& claps,
                                  const std::vector<Vector3>& places_m, const Vector3& centre_m);

/// The time from a source to an ear, by the shortest way round a spherical head.
[[nodiscard]] double travel_time_s(const Vector3& source_m, const Pose& world_from_head, int ear);

}  // namespace earpoint
