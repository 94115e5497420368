#include "speech_windows.h"

#include <gtest/gtest.h>

namespace earpoint {
namespace {

/// A hundred windows of noise at -70 dB with a crest factor of 12 dB.
std::vector<NearLevel> quiet_microphone() {
  std::vector<NearLevel> levels(100);
  for (std::size_t w = 0; w < levels.size(); ++w) {
    const auto little = static_cast<float>(w % 7);
    levels[w] = {-70.0F + 0.1F * little, -58.0F + 0.1F * little};
  }
  return levels;
}

void speak(std::vector<NearLevel>& levels, std::size_t from, std::size_t to, float level_db) {
  for (std::size_t w = from; w < to; ++w) levels[w] = {level_db, level_db + 14.0F};
}

TEST(SpeechWindows, WhoIsLoudestReTheirOwnVoiceSpeaks) {
  std::vector<std::vector<NearLevel>> levels{quiet_microphone(), quiet_microphone()};
  speak(levels[0], 10, 40, -20.0F);
  speak(levels[1], 50, 80, -35.0F);  // turned down
  speak(levels[1], 10, 40, -52.0F);  // hears the other
  const std::vector<SpeechWindow> windows = judge_windows(levels);
  EXPECT_EQ(windows[20].kind, WindowKind::speech);
  EXPECT_EQ(windows[20].speaker, 0);
  EXPECT_FALSE(windows[20].overlapping);
  EXPECT_EQ(windows[60].kind, WindowKind::speech);
  EXPECT_EQ(windows[60].speaker, 1);
  EXPECT_EQ(windows[5].kind, WindowKind::silent);
  EXPECT_EQ(windows[90].kind, WindowKind::silent);
}

TEST(SpeechWindows, TwoVoicesAtOnceOverlap) {
  std::vector<std::vector<NearLevel>> levels{quiet_microphone(), quiet_microphone()};
  speak(levels[0], 10, 45, -20.0F);
  speak(levels[1], 40, 80, -24.0F);
  const std::vector<SpeechWindow> windows = judge_windows(levels);
  EXPECT_TRUE(windows[42].overlapping);
  EXPECT_FALSE(windows[30].overlapping);
  EXPECT_FALSE(windows[60].overlapping);
}

TEST(SpeechWindows, SomebodyElsesMicrophoneHearsTheSpeakerAndNobodyOverlaps) {
  // The third person never speaks; all microphones pick up others 9 dB below their own wearer, as
  // in a small room.
  std::vector<std::vector<NearLevel>> levels{quiet_microphone(), quiet_microphone(),
                                             quiet_microphone()};
  for (int speaker = 0; speaker < 2; ++speaker) {
    const std::size_t from = speaker == 0 ? 10 : 50;
    for (int m = 0; m < 3; ++m) {
      speak(levels[static_cast<std::size_t>(m)], from, from + 30, m == speaker ? -20.0F : -29.0F);
    }
  }
  speak(levels[1], 35, 40, -22.0F);
  const std::vector<SpeechWindow> windows = judge_windows(levels);
  for (const std::size_t w : {12U, 30U, 52U, 79U}) {
    EXPECT_EQ(windows[w].speaker, w < 40 ? 0 : 1);
    EXPECT_FALSE(windows[w].overlapping) << w;
  }
  EXPECT_TRUE(windows[37].overlapping);
}

TEST(SpeechWindows, AKnockIsNoisy) {
  std::vector<std::vector<NearLevel>> levels{quiet_microphone()};
  speak(levels[0], 10, 60, -25.0F);
  levels[0][30] = {-20.0F, 0.0F};
  const std::vector<SpeechWindow> windows = judge_windows(levels);
  EXPECT_EQ(windows[30].kind, WindowKind::noisy);
  EXPECT_EQ(windows[31].kind, WindowKind::speech);
}

}  // namespace
}  // namespace earpoint
