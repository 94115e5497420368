#include "warnings.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/pose.h>

namespace earpoint {
namespace {

constexpr double kFov_rad = 0.5 * kPi;

/// A rendering within the training range.
RenderOutline usual() {
  RenderOutline outline;
  outline.duration_s = 3.0;
  outline.level_db = -30.0;
  outline.has_picture = true;
  outline.speaker_track = SpeakerTrack(Box{0.4, 0.2, 0.6, 0.9});
  outline.targets.emplace_back(Pose{{2, -4, 0.05}, quaternion_from_euler({.yaw_rad = 2.5})});
  return outline;
}

/// The only warning; "none" or "several" if it is not one.
std::string warning_of(const RenderOutline& outline, double fov_rad = kFov_rad,
                       const GtfDescription& description = {}) {
  const std::vector<std::string> warnings = gtf_warnings(description, outline, fov_rad);
  if (warnings.empty()) return "none";
  return warnings.size() == 1 ? warnings.front() : "several";
}

bool mentions(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(GtfWarnings, HasNoneWithinItsTrainingData) { EXPECT_EQ(warning_of(usual()), "none"); }

TEST(GtfWarnings, WarnsOfAFarMoveAlsoInTheMiddleOfAPath) {
  RenderOutline outline = usual();
  outline.targets.push_back(EarpointPath::parse_csv(
      "time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n0,1,0,0,0,0,0\n1.5,6,0,0,0,0,0\n3,1,0,0,0,0,0\n",
      "path"));
  EXPECT_TRUE(mentions(warning_of(outline), "6.0 m from the camera")) << warning_of(outline);
}

TEST(GtfWarnings, WarnsByTheRangeOfItsTraining) {
  RenderOutline outline = usual();
  outline.targets.emplace_back(
      Pose{{7, 0, 0}, quaternion_from_euler({.pitch_rad = radians_from_degrees(30)})});
  GtfDescription far_and_tilted;
  far_and_tilted.training_range = {.farthest_move_m = 8.0, .level_head_deg = 40.0};
  EXPECT_EQ(warning_of(outline, kFov_rad, far_and_tilted), "none");
  far_and_tilted.training_range.farthest_move_m = 6.5;
  EXPECT_TRUE(mentions(warning_of(outline, kFov_rad, far_and_tilted), "up to 6.5 m"));
  far_and_tilted.training_range = {.farthest_move_m = 8.0, .level_head_deg = 20.0};
  EXPECT_TRUE(mentions(warning_of(outline, kFov_rad, far_and_tilted), "up to 20 degrees"));
}

TEST(GtfWarnings, WarnsOfHeightAndTilt) {
  RenderOutline outline = usual();
  outline.targets.emplace_back(Pose{{1, 0, -0.4}, {}});
  EXPECT_TRUE(mentions(warning_of(outline), "0.4 m above or below")) << warning_of(outline);
  outline = usual();
  outline.targets.emplace_back(
      Pose{{1, 0, 0}, quaternion_from_euler({.roll_rad = radians_from_degrees(-20)})});
  EXPECT_TRUE(mentions(warning_of(outline), "by 20 degrees")) << warning_of(outline);
}

TEST(GtfWarnings, WarnsOfAMouthAtTheEarAndAFarSpeaker) {
  RenderOutline outline = usual();
  outline.speaker_m = Vector3{2.1, -4, 0.05};
  std::vector<std::string> warnings = gtf_warnings({}, outline, kFov_rad);
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_TRUE(mentions(warnings[0], "0.10 m from the speaker's mouth")) << warnings[0];
  EXPECT_TRUE(mentions(warnings[1], "4.5 m from the camera")) << warnings[1];
}

TEST(GtfWarnings, WarnsOfWhatItTakesForSilence) {
  RenderOutline outline = usual();
  outline.level_db = -85.0;
  EXPECT_TRUE(mentions(warning_of(outline), "-85 dB")) << warning_of(outline);
}

TEST(GtfWarnings, WarnsOfAGuessedSpeakerUnlessItNeedsNone) {
  RenderOutline outline = usual();
  outline.speaker_track.reset();
  EXPECT_TRUE(mentions(warning_of(outline), "estimated from picture and sound"))
      << warning_of(outline);
  GtfDescription boxless;
  boxless.box = false;
  EXPECT_EQ(warning_of(outline, kFov_rad, boxless), "none");
  outline.speaker_m = Vector3{2, 0, 0};
  EXPECT_EQ(warning_of(outline), "none");
}

TEST(GtfWarnings, WarnsOfAGuessedRoomUnlessItDoesNotLook) {
  RenderOutline outline = usual();
  outline.has_picture = false;
  EXPECT_TRUE(mentions(warning_of(outline), "no picture")) << warning_of(outline);
  GtfDescription sightless;
  sightless.picture_px = 0;
  EXPECT_EQ(warning_of(outline, kFov_rad, sightless), "none");
}

TEST(GtfWarnings, WarnsOfABoxBeyondItsView) {
  RenderOutline outline = usual();
  outline.speaker_track = SpeakerTrack(Box{0.0, 0.2, 0.1, 0.9});
  EXPECT_EQ(warning_of(outline), "none");
  // The edge of a field of view of 150 degrees is far outside of 90.
  EXPECT_TRUE(mentions(warning_of(outline, radians_from_degrees(150)), "leaves the 90 degrees"));
}

}  // namespace
}  // namespace earpoint
