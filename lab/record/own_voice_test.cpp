#include "own_voice.h"

#include <gtest/gtest.h>

namespace earpoint {
namespace {

/// A hundred moments of noise around a level.
std::vector<float> quiet_microphone(float level_db) {
  std::vector<float> levels(100);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    levels[i] = level_db + 0.1F * static_cast<float>(i % 7);
  }
  return levels;
}

void hear(std::vector<float>& levels, std::size_t from, std::size_t to, float level_db) {
  for (std::size_t i = from; i < to; ++i) levels[i] = level_db + static_cast<float>(i % 3);
}

TEST(OwnVoiceLevels, AreThoseOfWhoWearsTheMicrophone) {
  std::vector<std::vector<float>> levels{quiet_microphone(-70.0F), quiet_microphone(-85.0F)};
  hear(levels[0], 10, 40, -20.0F);
  hear(levels[1], 10, 40, -50.0F);
  hear(levels[1], 50, 80, -35.0F);  // turned down by 15 dB
  hear(levels[0], 50, 80, -36.0F);
  const std::vector<float> voices = own_voice_levels(levels);
  // The 80 % quantile of each voice's levels, which are 0, 1 and 2 dB above the given one.
  EXPECT_NEAR(voices[0], -18.0F, 1.0F);
  EXPECT_NEAR(voices[1], -33.0F, 1.0F);
}

TEST(OwnVoiceLevels, OfSomebodyWhoNeverSpeaksAreNotThoseOfTheOthers) {
  std::vector<std::vector<float>> levels{quiet_microphone(-70.0F), quiet_microphone(-70.0F),
                                         quiet_microphone(-60.0F)};
  hear(levels[0], 10, 40, -20.0F);
  hear(levels[1], 50, 80, -24.0F);
  for (const std::size_t from : {10, 50}) hear(levels[2], from, from + 30, -30.0F);
  // Of the level from quiet to a voice 45 dB count at most, which both voices exceed; the third
  // microphone, with 10 dB more gain, is quiet at -60 dB. Quiet levels span 0.6 dB, voices 2 dB.
  EXPECT_NEAR(own_voice_levels(levels)[2], -15.0F, 3.0F);
}

TEST(OwnVoiceLevels, ANoiseGateIsNoQuietMoment) {
  std::vector<std::vector<float>> levels{quiet_microphone(-120.0F), quiet_microphone(-60.0F)};
  hear(levels[0], 10, 40, -25.0F);
  hear(levels[1], 10, 40, -40.0F);
  hear(levels[1], 50, 80, -25.0F);
  hear(levels[0], 50, 80, -40.0F);
  const std::vector<float> voices = own_voice_levels(levels);
  // The 80 % quantile, as above.
  EXPECT_NEAR(voices[0], -23.0F, 1.0F);
  EXPECT_NEAR(voices[1], -23.0F, 1.0F);
}

}  // namespace
}  // namespace earpoint
