#include <gtest/gtest.h>

#include <earpoint/dataset/soundspaces_metadata.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

SoundSpacesClip a_clip() {
  SoundSpacesClip clip;
  clip.scene = "home";
  for (int v = 0; v < 2; ++v) {
    SoundSpacesViewpoint& viewpoint = clip.viewpoints.emplace_back();
    viewpoint.location = {0.1 + v, 1.5, -2.0 / 3.0};
    viewpoint.rotation_rad = 4.371246012664362;
    viewpoint.image = "test/home/0/view.png";
    viewpoint.rir = {{0, "a.wav"}, {1, "b.wav"}};
    viewpoint.bboxes = {{0, {140, 241, 2, 80}}, {1, {}}};
  }
  clip.speakers = {{.id = 0, .speech = "121-1217-0000", .location = {1, 2, 3}},
                   {.id = 1,
                    .speech = std::nullopt,
                    .location = {-1.0 / 3.0, 0, 0},
                    .rotation_rad = 0.1,
                    .gender = "female",
                    .figure = "woman"}};
  return clip;
}

TEST(SoundSpacesMetadata, WhatIsWrittenIsReadToTheLastBit) {
  const SoundSpacesClip clip = a_clip();
  const std::string text = soundspaces_metadata({&clip, 1});
  const auto read = parse_soundspaces_metadata(text, "metadata", "home");
  ASSERT_EQ(read.size(), 1U);
  ASSERT_EQ(read[0].viewpoints.size(), 2U);
  for (std::size_t v = 0; v < 2; ++v) {
    EXPECT_EQ(read[0].viewpoints[v].location, clip.viewpoints[v].location);
    EXPECT_EQ(read[0].viewpoints[v].rotation_rad, clip.viewpoints[v].rotation_rad);
    EXPECT_EQ(read[0].viewpoints[v].image, clip.viewpoints[v].image);
    EXPECT_EQ(read[0].viewpoints[v].rir, clip.viewpoints[v].rir);
    EXPECT_EQ(read[0].viewpoints[v].bboxes, clip.viewpoints[v].bboxes);
  }
  for (std::size_t s = 0; s < 2; ++s) {
    EXPECT_EQ(read[0].speakers[s].id, clip.speakers[s].id);
    EXPECT_EQ(read[0].speakers[s].speech, clip.speakers[s].speech);
    EXPECT_EQ(read[0].speakers[s].location, clip.speakers[s].location);
    EXPECT_EQ(read[0].speakers[s].rotation_rad, clip.speakers[s].rotation_rad);
    EXPECT_EQ(read[0].speakers[s].gender, clip.speakers[s].gender);
    EXPECT_EQ(read[0].speakers[s].figure, clip.speakers[s].figure);
  }
  EXPECT_EQ(soundspaces_metadata(read), text);
}

TEST(SoundSpacesMetadata, ABoxHoldsTheOutermostPixels) {
  // Rows 140 to 241 and columns 2 to 80 of 256.
  const Box box{
      .x_min = 2 / 256.0, .y_min = 140 / 256.0, .x_max = 81 / 256.0, .y_max = 242 / 256.0};
  EXPECT_EQ(soundspaces_box(box), (SoundSpacesBox{140, 241, 2, 80}));
  EXPECT_EQ(from_soundspaces_box({140, 241, 2, 80}), box);
  const Box whole{.x_min = 0, .y_min = 0, .x_max = 1, .y_max = 1};
  EXPECT_EQ(soundspaces_box(whole), (SoundSpacesBox{0, 255, 0, 255}));
}

TEST(SoundSpacesMetadata, AHiddenSpeakerHasFourZeros) {
  EXPECT_EQ(soundspaces_box(std::nullopt), (SoundSpacesBox{0, 0, 0, 0}));
  EXPECT_EQ(from_soundspaces_box({0, 0, 0, 0}), std::nullopt);
}

TEST(SoundSpacesMetadata, HeadingsGrowToTheLeftFromAheadAndStayWithinATurn) {
  EXPECT_EQ(soundspaces_heading_rad(quaternion_from_euler({})), 0.0);
  EXPECT_NEAR(soundspaces_heading_rad(quaternion_from_euler({.yaw_rad = kPi / 2})), kPi / 2, 1e-12);
  EXPECT_NEAR(soundspaces_heading_rad(quaternion_from_euler({.yaw_rad = -kPi / 2})), 1.5 * kPi,
              1e-12);
}

TEST(SoundSpacesMetadata, SpeechLiesWhereTheReleasedLoaderLooks) {
  EXPECT_EQ(soundspaces_speech_file("train", "100-121669-0004"),
            "train-clean-360/100/121669/100-121669-0004.flac");
  EXPECT_EQ(soundspaces_speech_file("val-seen", "1-2-3"), "dev-clean/1/2/1-2-3.flac");
  EXPECT_EQ(soundspaces_speech_file("test", "1-2-3"), "test-clean/1/2/1-2-3.flac");
  EXPECT_THROW(soundspaces_speech_file("test", "1-2"), InputError);
}

}  // namespace
}  // namespace earpoint
