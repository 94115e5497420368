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
  // Behind, 10 degrees to either side of the back: the mean is the back, not the front.
  const double aside_rad = radians_from_degrees(10.0);
  const LocatedSpeaker located =
      mean_speaker({sighting(kPi - aside_rad, 1.0, 0.1), sighting(-kPi + aside_rad, 4.0, 0.1),
                    sighting(0.3, 9.0, 0.0)});
  EXPECT_NEAR(located.speaker.position_m.x, -2.0, 1e-9);  // the geometric mean of 1 and 4
  EXPECT_NEAR(located.speaker.position_m.y, 0.0, 1e-9);
  EXPECT_NEAR(located.speaker.position_m.z, 0.1, 1e-12);
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
  RenderSource source;
  source.sound.path = path;
  SilentProgress progress;
  LocatedSpeaker located = locate_speaker(source, weights, 0.5 * kPi, progress);
  std::filesystem::remove(path);
  // 2.7 s: two windows, and a rest that is more than half of one.
  ASSERT_EQ(located.sightings.size(), 3U);
  EXPECT_EQ(located.sightings[2].time_s, 2.5);
  EXPECT_FALSE(located.has_picture);
  EXPECT_FALSE(located.has_box);

  const Image map = plot_speaker(located, 0.5 * kPi);
  EXPECT_EQ(map.channels(), 3);
  // A speaker whom the map must stretch to hold.
  located.speaker.position_m = {-8, 6, 0};
  EXPECT_EQ(plot_speaker(located, 0.5 * kPi).width(), map.width());
}

}  // namespace
}  // namespace earpoint
