#include "speech_windows.h"

#include <algorithm>
#include <cmath>

#include <earpoint/core/error.h>

namespace earpoint {
namespace {

constexpr double kQuiet = 0.10;
constexpr double kLoud = 0.95;
constexpr double kUsualPeak = 0.99;
constexpr float kKnock_db = 6.0F;
constexpr float kSecondBelow_db = 12.0F;
constexpr float kLeastSpan_db =
    6.0F;  ///< between quiet and loud, of a microphone that heard speech

float quantile(std::vector<float> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

struct Thresholds {
  float loud_db = 0.0F;
  float speech_db = 0.0F;
  float knock_db = 0.0F;
};

Thresholds thresholds_of(const std::vector<NearLevel>& windows) {
  std::vector<float> levels;
  std::vector<float> peaks;
  for (const NearLevel& window : windows) {
    levels.push_back(window.level_db);
    peaks.push_back(window.peak_db);
  }
  Thresholds thresholds;
  thresholds.loud_db = quantile(levels, kLoud);
  const float quiet_db = quantile(levels, kQuiet);
  // Somebody who never stops has no quiet windows.
  const bool pauses = thresholds.loud_db - quiet_db >= kLeastSpan_db;
  thresholds.speech_db =
      pauses ? 0.5F * (quiet_db + thresholds.loud_db) : thresholds.loud_db - kSecondBelow_db;
  thresholds.knock_db = quantile(peaks, kUsualPeak) + kKnock_db;
  return thresholds;
}

}  // namespace

std::vector<SpeechWindow> judge_windows(std::span<const std::vector<NearLevel>> levels) {
  EARPOINT_CHECK(!levels.empty());
  std::vector<SpeechWindow> windows(levels.front().size());
  if (windows.empty()) return windows;
  std::vector<Thresholds> thresholds;
  for (const auto& microphone : levels) {
    EARPOINT_CHECK(microphone.size() == windows.size());
    thresholds.push_back(thresholds_of(microphone));
  }
  for (std::size_t w = 0; w < windows.size(); ++w) {
    SpeechWindow& window = windows[w];
    float loudest_db = -1e9F;
    bool knock = false;
    for (std::size_t m = 0; m < levels.size(); ++m) {
      const float re_loud_db = levels[m][w].level_db - thresholds[m].loud_db;
      if (re_loud_db > loudest_db) {
        loudest_db = re_loud_db;
        window.speaker = static_cast<int>(m);
      }
      knock = knock || levels[m][w].peak_db > thresholds[m].knock_db;
    }
    for (std::size_t m = 0; m < levels.size(); ++m) {
      const float level_db = levels[m][w].level_db;
      const bool speaks = level_db >= thresholds[m].speech_db;
      if (static_cast<int>(m) == window.speaker) {
        window.kind = knock ? WindowKind::noisy : speaks ? WindowKind::speech : WindowKind::silent;
      } else if (speaks && level_db >= thresholds[m].loud_db - kSecondBelow_db) {
        window.overlapping = true;
      }
    }
  }
  return windows;
}

}  // namespace earpoint
