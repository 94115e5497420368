#include "own_voice.h"

#include <algorithm>
#include <limits>
#include <optional>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kQuiet = 0.05;
constexpr double kLoud = 0.95;
constexpr double kVoice = 0.8;            ///< quantile of a wearer's moments
constexpr float kSpeechRange_db = 20.0F;  ///< of one voice; lower levels are pauses
constexpr float kClearly_db = 5.0F;
constexpr float kMostSpan_db = 45.0F;  ///< from quiet to loud; a noise gate would make it larger
constexpr std::size_t kFewest = 4;     ///< moments needed to estimate a level
constexpr int kRounds = 4;

/// For each microphone, its levels in the moments when it is clearly the loudest re the given
/// levels.
std::vector<std::vector<float>> own_moments(std::span<const std::vector<float>> levels,
                                            const std::vector<float>& reference_db) {
  std::vector<std::vector<float>> own(levels.size());
  for (std::size_t i = 0; i < levels.front().size(); ++i) {
    float loudest = std::numeric_limits<float>::lowest();
    float second = loudest;
    std::size_t microphone = 0;
    for (std::size_t m = 0; m < levels.size(); ++m) {
      const float level = levels[m][i] - reference_db[m];
      if (level > loudest) {
        second = loudest;
        loudest = level;
        microphone = m;
      } else {
        second = std::max(second, level);
      }
    }
    if (loudest > second + kClearly_db) own[microphone].push_back(levels[microphone][i]);
  }
  return own;
}

/// @return nothing if there are too few moments to tell
std::optional<float> voice_level(std::vector<float> own) {
  if (own.size() < kFewest) return std::nullopt;
  const float top = *std::ranges::max_element(own);
  std::erase_if(own, [&](float level) { return level < top - kSpeechRange_db; });
  return quantile(std::move(own), kVoice);
}

}  // namespace

float quantile(std::vector<float> values, double share) {
  EARPOINT_CHECK(!values.empty());
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::vector<float> own_voice_levels(std::span<const std::vector<float>> levels) {
  EARPOINT_CHECK(!levels.empty());
  std::vector<float> quiet_db;
  for (const auto& microphone : levels) {
    EARPOINT_CHECK(microphone.size() == levels.front().size());
    quiet_db.push_back(
        std::max(quantile(microphone, kQuiet), quantile(microphone, kLoud) - kMostSpan_db));
  }
  std::vector<float> voice_db = quiet_db;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<std::optional<float>> found;
    float span_db = 0.0F;
    int known = 0;
    for (auto& own : own_moments(levels, voice_db)) {
      found.push_back(voice_level(std::move(own)));
      if (!found.back()) continue;
      span_db += *found.back() - quiet_db[found.size() - 1];
      ++known;
    }
    if (known == 0) break;
    span_db /= static_cast<float>(known);
    for (std::size_t m = 0; m < levels.size(); ++m) {
      voice_db[m] = found[m].value_or(quiet_db[m] + span_db);
    }
  }
  return voice_db;
}

}  // namespace earpoint
