#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/random.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/network_testing/random_weights.h>
#include <earpoint/render_files/locate_speaker.h>

namespace earpoint {
namespace {

SpeakerSighting sighting(double azimuth_rad, double distance_m, double level) {
  return {0.0,
          {{distance_m * std::cos(azimuth_rad), distance_m * std::sin(azimuth_rad), 0.1}, 0.5, 0.8},
          level};
}

TEST(LocateSpeaker, TheMeanGoesRoundTheBackAndHearsTheLoud) {
  // 10 degrees to either side of the back: the mean is the back, not the front.
  const double aside_rad = radians_from_degrees(10.0);
  const LocatedSpeaker located =
      mean_speaker({sighting(kPi - aside_rad, 1.0, 0.1), sighting(-kPi + aside_rad, 4.0, 0.1),
                    sighting(0.3, 9.0, 0.0)});
  EXPECT_NEAR(located.speaker.position_m.x, -2.0, 1e-9);  // the geometric mean of 1 and 4
  EXPECT_NEAR(located.speaker.position_m.y, 0.0, 1e-9);
  EXPECT_NEAR(located.speaker.position_m.z, 0.1, 1e-12);
  // The circular deviation, sqrt(-2 ln cos a), is 0.25 % above a.
  EXPECT_NEAR(located.azimuth_spread_rad, aside_rad, 0.01 * aside_rad);
  EXPECT_NEAR(located.log_distance_spread, std::log(2.0), 1e-9);
  EXPECT_NEAR(located.speaker.yaw_rad, 0.5, 1e-12);
  EXPECT_NEAR(located.speaker.yaw_certainty, 0.8, 1e-12);
}

TEST(LocateSpeaker, OneSightingHasNoSpread) {
  const LocatedSpeaker located = mean_speaker({sighting(0.4, 2.0, 0.1)});
  EXPECT_NEAR(located.azimuth_spread_rad, 0.0, 1e-6);
  EXPECT_NEAR(located.log_distance_spread, 0.0, 1e-6);
}

TEST(LocateSpeaker, HearsEveryWindowOfARecording) {
  GtfDescription description;
  description.channels = 8;
  description.layers = 1;
  description.picture_px = 0;
  GtfWeights weights{description, {}, {}};
  RandomStream random(1);
  weights.tensors = random_tensors(required_tensors(description), random, 0.0, 0.1);
  Waveform sound(2, 48000 * 27 / 10, 48000);
  for (float& sample : sound.planar()) sample = static_cast<float>(0.1 * random.normal());
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / ("locate." + std::to_string(::getpid()) + ".wav");
  write_sound(path, sound, SampleFormat::float32);
  RenderInput source;
  source.sound.path = path;
  SilentProgress progress;
  const LocatedSpeaker located = locate_speaker(source, weights, 0.5 * kPi, progress);
  std::filesystem::remove(path);
  // 2.7 s: two windows, and a remainder of more than half a window.
  ASSERT_EQ(located.sightings.size(), 3U);
  EXPECT_EQ(located.sightings[2].time_s, 2.5);
  EXPECT_FALSE(located.has_picture);
  EXPECT_FALSE(located.has_box);
  for (const SpeakerSighting& found : located.sightings) {
    // Resampling from 48 to 16 kHz keeps the lower third of white noise's power, except for the
    // last twentieth of its band. The last window has 0.7 s of sound.
    const double level = 0.1 * std::sqrt((found.time_s > 2.0 ? 0.7 : 1.0) / 3.0);
    EXPECT_LT(found.level, level * 1.03)
        << "five deviations of a mean of 11,200 squares or more, twice";
    EXPECT_GT(found.level, level * 0.95);
    EXPECT_GT(norm(found.speaker.position_m), 0.0);
  }
}

/// Where the speaker's dot is on a map, in pixels: the mean place of the pixels in the speaker's
/// colour, which nothing else has.
struct Dot {
  double x = 0.0;
  double y = 0.0;
  int pixels = 0;
};

Dot speaker_dot(const Image& map) {
  Dot dot;
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      if (map.at(x, y, 0) != 224 || map.at(x, y, 1) != 142 || map.at(x, y, 2) != 43) continue;
      dot.x += x;
      dot.y += y;
      ++dot.pixels;
    }
  }
  dot.x /= dot.pixels;
  dot.y /= dot.pixels;
  return dot;
}

TEST(LocateSpeaker, TheMapHasTheSpeakerWhereTheyAre) {
  const auto map_of = [](const Vector3& speaker_m) {
    LocatedSpeaker located;
    located.speaker.position_m = speaker_m;
    // One sighting at each side keeps the map's scale constant.
    located.sightings = {sighting(0.5 * kPi, 3.0, 0.1), sighting(-0.5 * kPi, 3.0, 0.1)};
    return plot_speaker(located, 0.5 * kPi);
  };
  const Image map = map_of({1, 0, 0});
  ASSERT_EQ(map.channels(), 3);
  const Dot ahead = speaker_dot(map), left = speaker_dot(map_of({1, 1, 0}));
  const Dot further = speaker_dot(map_of({2, 0, 0}));
  // The dot is 18 pixels wide and has 254 pixels, of which those at the edge are blended with the
  // background.
  ASSERT_GT(ahead.pixels, 150);
  EXPECT_NEAR(ahead.x, map.width() / 2.0, 1.0) << "ahead of the camera is the middle of the page";
  const double metre_px = ahead.x - left.x;
  EXPECT_GT(metre_px, 20.0) << "left is left";
  // The mean of the pixels that are wholly covered is within one pixel of the centre.
  EXPECT_NEAR(left.y, ahead.y, 1.0);
  EXPECT_NEAR(ahead.y - further.y, metre_px, 1.0) << "front is up, at the same scale";
  EXPECT_NEAR(further.x, ahead.x, 1.0);
}

TEST(LocateSpeaker, TheMapHoldsASpeakerFarBehindTheCamera) {
  LocatedSpeaker located = mean_speaker({sighting(0.0, 1.0, 0.1)});
  located.speaker.position_m = {-8, 6, 0};
  const Image map = plot_speaker(located, 0.5 * kPi);
  const Dot dot = speaker_dot(map);
  ASSERT_GT(dot.pixels, 150) << "the whole dot";
  EXPECT_LT(dot.x, map.width() / 2.0);
  EXPECT_GT(dot.y, map.height() / 2.0);
}

}  // namespace
}  // namespace earpoint
