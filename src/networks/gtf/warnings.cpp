#include "warnings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include <earpoint/gtf/training_range.h>
#include <earpoint/gtf/view.h>
#include <earpoint/pose.h>

namespace earpoint {
namespace {

// Below it the network treats everything as silence.
constexpr double kQuietest_db = -80.0;
constexpr double kStep_s = 0.1;

/// The extremes of all targets over the recording.
struct Reach {
  double distance_m = 0.0;
  double height_m = 0.0;  ///< up or down
  double tilt_rad = 0.0;  ///< pitch or roll
  double nearest_speaker_m = 1e9;
};

Reach reach_of(const RenderOutline& outline) {
  Reach reach;
  const auto include = [&](const Pose& pose) {
    const EulerAngles angles = euler_from_quaternion(pose.orientation);
    reach.distance_m = std::max(reach.distance_m, norm(pose.position_m));
    reach.height_m = std::max(reach.height_m, std::abs(pose.position_m.z));
    reach.tilt_rad =
        std::max({reach.tilt_rad, std::abs(angles.pitch_rad), std::abs(angles.roll_rad)});
    if (outline.speaker_m) {
      reach.nearest_speaker_m =
          std::min(reach.nearest_speaker_m, norm(*outline.speaker_m - pose.position_m));
    }
  };
  const auto steps = static_cast<std::ptrdiff_t>(outline.duration_s / kStep_s);
  for (const EarpointPath& target : outline.targets) {
    for (std::ptrdiff_t i = 0; i <= (target.is_moving() ? steps : 0); ++i) {
      include(target.at(static_cast<double>(i) * kStep_s));
    }
  }
  return reach;
}

/// Whether at some time the speaker's box lies outside of what the network is shown.
bool leaves_view(const RenderOutline& outline, double horizontal_fov_rad) {
  for (double time_s = 0.0; time_s <= outline.duration_s; time_s += 1.0) {
    const std::optional<Box> box = outline.speaker_track->at(time_s);
    if (box && !gtf_view(nullptr, box, horizontal_fov_rad, 1).speaker_box) return true;
  }
  return false;
}

void warn_of_missing_input(const GtfDescription& description, const RenderOutline& outline,
                           double horizontal_fov_rad, std::vector<std::string>& warnings) {
  const bool looks = description.picture_px > 0;
  if (looks && !outline.has_picture) {
    warnings.emplace_back("no picture given: the room is estimated from the sound alone");
  }
  if (!description.box || outline.speaker_m) return;
  if (!outline.speaker_track) {
    warnings.push_back(
        fmt::format("no speaker given: estimated from {}; to be sure, give the speaker's position "
                    "or the speaker's box",
                    looks && outline.has_picture ? "picture and sound" : "the sound"));
  } else if (leaves_view(outline, horizontal_fov_rad)) {
    warnings.emplace_back("the speaker's box leaves the 90 degrees of view that gtf uses");
  }
}

}  // namespace

std::vector<std::string> gtf_warnings(const GtfDescription& description,
                                      const RenderOutline& outline, double horizontal_fov_rad) {
  std::vector<std::string> warnings;
  const GtfTrainingRange& range = description.training_range;
  const Reach reach = reach_of(outline);
  if (reach.distance_m > range.farthest_move_m) {
    warnings.push_back(
        fmt::format("the target is {:.1f} m from the camera; gtf was trained for up to {:g} m",
                    reach.distance_m, range.farthest_move_m));
  }
  if (reach.height_m > range.level_move_m) {
    warnings.push_back(fmt::format(
        "the target is {:.1f} m above or below the camera; gtf was trained for up to {:g} m",
        reach.height_m, range.level_move_m));
  }
  if (reach.tilt_rad > radians_from_degrees(range.level_head_deg)) {
    warnings.push_back(fmt::format(
        "the head pitches or rolls by {:.0f} degrees; gtf was trained for up to {:g} degrees",
        degrees_from_radians(reach.tilt_rad), range.level_head_deg));
  }
  if (reach.nearest_speaker_m < GtfDescription::kNearestSpeaker_m) {
    warnings.push_back(fmt::format(
        "the target is {:.2f} m from the speaker's mouth; the level does not rise below {:g} m",
        reach.nearest_speaker_m, GtfDescription::kNearestSpeaker_m));
  }
  if (outline.speaker_m && norm(*outline.speaker_m) > range.farthest_speaker_m) {
    warnings.push_back(
        fmt::format("the speaker is {:.1f} m from the camera; gtf was trained for up to {:g} m",
                    norm(*outline.speaker_m), range.farthest_speaker_m));
  }
  if (outline.level_db < kQuietest_db) {
    warnings.push_back(
        fmt::format("the recording's level is {:.0f} dB; below {:g} dB gtf treats it as silence",
                    outline.level_db, kQuietest_db));
  }
  warn_of_missing_input(description, outline, horizontal_fov_rad, warnings);
  return warnings;
}

}  // namespace earpoint
