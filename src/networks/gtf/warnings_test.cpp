#include "warnings.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/pose.h>

namespace earpoint {
namespace {

constexpr double kFov_rad = 0.5 * kPi;

/// A rendering that a network was made for.
RenderOutline usual() {
  RenderOutline outline;
  outline.duration_s = 3.0;
  outline.level_db = -30.0;
  outline.has_picture = true;
  outline.speaker_track = SpeakerTrack(Box{0.4, 0.2, 0.6, 0.9});
  outline.targets.emplace_back(Pose{{2, -4, 0.05}, quaternion_from_euler({.yaw_rad = 2.5})});
  return outline;
}

/// The only doubt there is; "none" or "several" if it is not one.
std::string doubt_of(const RenderOutline& outline, double fov_rad = kFov_rad,
                     const GtfDescription& description = {}) {
  const std::vector<std::string> doubts = gtf_doubts(description, outline, fov_rad);
  if (doubts.empty()) return "none";
  return doubts.size() == 1 ? doubts.front() : "several";
}

bool mentions(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(GtfDoubts, HasNoneWhereItIsAtHome) { EXPECT_EQ(doubt_of(usual()), "none"); }

TEST(GtfDoubts, DoubtsAFarMoveAlsoInTheMiddleOfAPath) {
  RenderOutline outline = usual();
  outline.targets.push_back(EarpointPath::parse_csv(
      "time_s,x,y,z,yaw_deg,pitch_deg,roll_deg\n0,1,0,0,0,0,0\n1.5,6,0,0,0,0,0\n3,1,0,0,0,0,0\n",
      "path"));
  EXPECT_TRUE(mentions(doubt_of(outline), "6.0 m from the camera")) << doubt_of(outline);
}

TEST(GtfDoubts, DoubtsByTheRangeOfItsTraining) {
  RenderOutline outline = usual();
  outline.targets.emplace_back(
      Pose{{7, 0, 0}, quaternion_from_euler({.pitch_rad = radians_from_degrees(30)})});
  GtfDescription far_and_tilted;
  far_and_tilted.training_range = {.farthest_move_m = 8.0, .level_head_deg = 40.0};
  EXPECT_EQ(doubt_of(outline, kFov_rad, far_and_tilted), "none");
  far_and_tilted.training_range.farthest_move_m = 6.5;
  EXPECT_TRUE(mentions(doubt_of(outline, kFov_rad, far_and_tilted), "up to 6.5 m"));
}

TEST(GtfDoubts, DoubtsHeightAndTilt) {
  RenderOutline outline = usual();
  outline.targets.emplace_back(Pose{{1, 0, -0.4}, {}});
  EXPECT_TRUE(mentions(doubt_of(outline), "0.4 m above or below")) << doubt_of(outline);
  outline = usual();
  outline.targets.emplace_back(
      Pose{{1, 0, 0}, quaternion_from_euler({.roll_rad = radians_from_degrees(-20)})});
  EXPECT_TRUE(mentions(doubt_of(outline), "by 20 degrees")) << doubt_of(outline);
}

TEST(GtfDoubts, DoubtsAMouthAtTheEarAndAFarSpeaker) {
  RenderOutline outline = usual();
  outline.speaker_m = Vector3{2.1, -4, 0.05};
  std::vector<std::string> doubts = gtf_doubts({}, outline, kFov_rad);
  ASSERT_EQ(doubts.size(), 2U);
  EXPECT_TRUE(mentions(doubts[0], "0.10 m from the speaker's mouth")) << doubts[0];
  EXPECT_TRUE(mentions(doubts[1], "4.5 m from the camera")) << doubts[1];
}

TEST(GtfDoubts, DoubtsWhatItTakesForSilence) {
  RenderOutline outline = usual();
  outline.level_db = -85.0;
  EXPECT_TRUE(mentions(doubt_of(outline), "-85 dB")) << doubt_of(outline);
}

TEST(GtfDoubts, DoubtsAGuessedSpeakerUnlessItNeedsNone) {
  RenderOutline outline = usual();
  outline.speaker_track.reset();
  EXPECT_TRUE(mentions(doubt_of(outline), "by picture and sound")) << doubt_of(outline);
  GtfDescription boxless;
  boxless.box = false;
  EXPECT_EQ(doubt_of(outline, kFov_rad, boxless), "none");
  outline.speaker_m = Vector3{2, 0, 0};
  EXPECT_EQ(doubt_of(outline), "none");
}

TEST(GtfDoubts, DoubtsAGuessedRoomUnlessItDoesNotLook) {
  RenderOutline outline = usual();
  outline.has_picture = false;
  EXPECT_TRUE(mentions(doubt_of(outline), "no picture")) << doubt_of(outline);
  GtfDescription sightless;
  sightless.picture_px = 0;
  EXPECT_EQ(doubt_of(outline, kFov_rad, sightless), "none");
}

TEST(GtfDoubts, DoubtsABoxBeyondItsView) {
  RenderOutline outline = usual();
  outline.speaker_track = SpeakerTrack(Box{0.0, 0.2, 0.1, 0.9});
  EXPECT_EQ(doubt_of(outline), "none");
  // At the edge of 150 degrees that is far outside of 90.
  EXPECT_TRUE(mentions(doubt_of(outline, radians_from_degrees(150)), "leaves the 90 degrees"));
}

}  // namespace
}  // namespace earpoint
