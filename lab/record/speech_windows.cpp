#include "speech_windows.h"

#include "own_voice.h"

#include <algorithm>
#include <limits>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kQuiet = 0.10;
constexpr double kUsualPeak = 0.99;
constexpr float kKnock_db = 6.0F;
constexpr float kSpeechBelow_db = 12.0F;  ///< the own voice, for people who never pause
/// A second voice is heard if its microphone is less below the first's than this share of the usual
/// crosstalk, in dB.
constexpr float kOfCrosstalk = 0.5F;
constexpr double kUsualCrosstalk = 0.25;  ///< quantile; higher levels may be a voice
constexpr float kLeastSpan_db =
    6.0F;  ///< between quiet and loud, of a microphone that picked up speech

struct Thresholds {
  float voice_db = 0.0F;
  float speech_db = 0.0F;
  float knock_db = 0.0F;
};

std::vector<Thresholds> thresholds_of(std::span<const std::vector<NearLevel>> levels) {
  std::vector<std::vector<float>> levels_db;
  std::vector<Thresholds> thresholds;
  for (const auto& microphone : levels) {
    EARPOINT_CHECK(microphone.size() == levels.front().size());
    auto& own_db = levels_db.emplace_back();
    std::vector<float> peaks_db;
    for (const NearLevel& window : microphone) {
      own_db.push_back(window.level_db);
      peaks_db.push_back(window.peak_db);
    }
    thresholds.push_back({.knock_db = quantile(std::move(peaks_db), kUsualPeak) + kKnock_db});
  }
  const std::vector<float> voices_db = own_voice_levels(levels_db);
  for (std::size_t m = 0; m < levels.size(); ++m) {
    const float quiet_db = quantile(levels_db[m], kQuiet);
    // People who never pause have no quiet windows.
    const bool pauses = voices_db[m] - quiet_db >= kLeastSpan_db;
    thresholds[m].voice_db = voices_db[m];
    thresholds[m].speech_db =
        pauses ? 0.5F * (quiet_db + voices_db[m]) : voices_db[m] - kSpeechBelow_db;
  }
  return thresholds;
}

float re_voice_db(const NearLevel& window, const Thresholds& thresholds) {
  return window.level_db - thresholds.voice_db;
}

/// [speaker][other]: usual level of the other's microphone below the speaker's, each re its own
/// wearer's voice.
std::vector<std::vector<float>> crosstalk_db(std::span<const std::vector<NearLevel>> levels,
                                             const std::vector<Thresholds>& thresholds,
                                             const std::vector<SpeechWindow>& windows) {
  std::vector<std::vector<float>> usual(levels.size(), std::vector<float>(levels.size()));
  for (std::size_t speaker = 0; speaker < levels.size(); ++speaker) {
    for (std::size_t other = 0; other < levels.size(); ++other) {
      std::vector<float> differences;
      for (std::size_t w = 0; w < windows.size(); ++w) {
        if (windows[w].kind != WindowKind::speech ||
            static_cast<std::size_t>(windows[w].speaker) != speaker) {
          continue;
        }
        differences.push_back(re_voice_db(levels[other][w], thresholds[other]) -
                              re_voice_db(levels[speaker][w], thresholds[speaker]));
      }
      if (!differences.empty()) {
        usual[speaker][other] = quantile(std::move(differences), kUsualCrosstalk);
      }
    }
  }
  return usual;
}

}  // namespace

std::vector<SpeechWindow> judge_windows(std::span<const std::vector<NearLevel>> levels) {
  EARPOINT_CHECK(!levels.empty());
  std::vector<SpeechWindow> windows(levels.front().size());
  if (windows.empty()) return windows;
  const std::vector<Thresholds> thresholds = thresholds_of(levels);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    SpeechWindow& window = windows[w];
    float loudest_db = std::numeric_limits<float>::lowest();
    bool knock = false;
    for (std::size_t m = 0; m < levels.size(); ++m) {
      const float level_db = re_voice_db(levels[m][w], thresholds[m]);
      if (level_db > loudest_db) {
        loudest_db = level_db;
        window.speaker = static_cast<int>(m);
      }
      knock = knock || levels[m][w].peak_db > thresholds[m].knock_db;
    }
    const auto speaker = static_cast<std::size_t>(window.speaker);
    const bool speaks = levels[speaker][w].level_db >= thresholds[speaker].speech_db;
    window.kind = knock ? WindowKind::noisy : speaks ? WindowKind::speech : WindowKind::silent;
  }
  const auto crosstalk = crosstalk_db(levels, thresholds, windows);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    if (windows[w].kind != WindowKind::speech) continue;
    const auto speaker = static_cast<std::size_t>(windows[w].speaker);
    for (std::size_t m = 0; m < levels.size(); ++m) {
      const float below_db = re_voice_db(levels[m][w], thresholds[m]) -
                             re_voice_db(levels[speaker][w], thresholds[speaker]);
      if (m != speaker && levels[m][w].level_db >= thresholds[m].speech_db &&
          below_db >= kOfCrosstalk * crosstalk[speaker][m]) {
        windows[w].overlapping = true;
      }
    }
  }
  return windows;
}

}  // namespace earpoint
