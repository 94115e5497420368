#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/locate/microphone_map.h>

namespace earpoint {
namespace {

constexpr double kSilence_db = -60.0;

/// Three people who walk around and talk in turns in front of some cameras; person p wears
/// microphone `microphone_of[p]`.
struct Session {
  std::vector<std::size_t> microphone_of{0, 1, 2};
  std::vector<NearRangeMoment> moments;

  Session(std::uint64_t seed, int seconds, int cameras, double walks_m, bool hears_direction) {
    RandomStream random(seed);
    for (std::size_t i = 2; i > 0; --i) {
      std::swap(microphone_of[i], microphone_of[random.index(i + 1)]);
    }
    std::vector<double> gain_db(3), phase(3);
    for (double& gain : gain_db) gain = 20.0 + 2.0 * random.normal();
    for (double& value : phase) value = random.uniform(0.0, 6.28);
    std::size_t speaker = 0;
    for (int t = 0; t < seconds; ++t) {
      if (t % 4 == 0) speaker = random.index(3);
      for (int camera = 0; camera < cameras; ++camera) {
        moments.push_back(moment(random, gain_db, phase, speaker, t, camera, walks_m));
        if (!hears_direction) continue;
        // The right direction is usually the likeliest, but a reflection may seem likelier.
        auto& logs = moments.back().direction_log_likelihood;
        for (std::size_t p = 0; p < 3; ++p) {
          logs.push_back((p == speaker ? 2.0 : 0.0) + 1.5 * random.normal());
        }
      }
    }
  }

  [[nodiscard]] NearRangeMoment moment(RandomStream& random, const std::vector<double>& gain_db,
                                       const std::vector<double>& phase, std::size_t speaker, int t,
                                       int camera, double walks_m) const {
    NearRangeMoment result;
    result.near_db.assign(3, -70.0);
    const double voice_db = -20.0 + 3.0 * random.normal();
    for (std::size_t p = 0; p < 3; ++p) {
      const double angle = 2.1 * static_cast<double>(p);
      const double swing = walks_m * std::sin(0.2 * t + phase[p]);
      const double x = std::cos(angle) + swing, y = std::sin(angle) + 0.5 * swing;
      const double distance =
          std::hypot(x - 3.0 * std::cos(0.8 * camera), y - 3.0 * std::sin(0.8 * camera));
      const bool is_seen = random.uniform() > 0.2;
      result.distance_m.push_back(is_seen ? std::optional(distance) : std::nullopt);
      // Other people's microphones pick up the speaker at -15 dB.
      result.near_db[microphone_of[p]] = voice_db + gain_db[p] - (p == speaker ? 0.0 : 15.0);
      if (p == speaker) {
        result.camera_db = voice_db - 20.0 * std::log10(distance) + 2.0 * random.normal();
      }
    }
    return result;
  }

  [[nodiscard]] bool is_right(const MicrophoneMap& map) const {
    for (std::size_t p = 0; p < 3; ++p) {
      if (map.person_of[microphone_of[p]] != p) return false;
    }
    return true;
  }
};

int right_of_twenty(int seconds, int cameras, double walks_m, bool hears_direction) {
  int right = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Session session(seed, seconds, cameras, walks_m, hears_direction);
    right += session.is_right(match_microphones(session.moments, kSilence_db)) ? 1 : 0;
  }
  return right;
}

TEST(MatchMicrophones, FindsWhoWearsWhichByLevelAgainstDistance) {
  // Two minutes in front of one camera while people walk; guessing gives 3.3 of 20.
  EXPECT_GE(right_of_twenty(120, 1, 1.5, false), 18);
  // Eight cameras around people who stay where they are.
  EXPECT_GE(right_of_twenty(120, 8, 0.0, false), 18);
}

TEST(MatchMicrophones, FindsThemByDirectionWhereNobodyMovesBeforeOneCamera) {
  EXPECT_GE(right_of_twenty(120, 1, 0.0, true), 19);
}

TEST(MatchMicrophones, KnowsHowSureItIs) {
  const Session session(1, 120, 8, 1.0, true);
  const auto heard = match_microphones(session.moments, kSilence_db);
  ASSERT_EQ(heard.certainty.size(), 3U);
  for (const double certainty : heard.certainty) EXPECT_GT(certainty, 0.95);
  // Nobody speaks: all pairings are equally likely.
  const auto silent = match_microphones(session.moments, 100.0);
  ASSERT_EQ(silent.certainty.size(), 3U);
  for (const double certainty : silent.certainty) EXPECT_NEAR(certainty, 0.5, 1e-9);
}

TEST(MatchMicrophones, LeavesAMicrophoneWithoutAPersonWhereThereAreFewer) {
  Session session(2, 60, 8, 1.0, false);
  for (NearRangeMoment& moment : session.moments) moment.distance_m.pop_back();
  const auto map = match_microphones(session.moments, kSilence_db);
  EXPECT_EQ(std::count(map.person_of.begin(), map.person_of.end(), std::nullopt), 1);
  EXPECT_EQ(map.person_of[session.microphone_of[0]], 0U);
  EXPECT_TRUE(match_microphones({}, kSilence_db).person_of.empty());
}

TEST(LoudestMicrophone, IsNobodysInSilence) {
  EXPECT_EQ(loudest_microphone(std::vector{-30.0, -20.0, -40.0}, kSilence_db), 1U);
  EXPECT_EQ(loudest_microphone(std::vector{-70.0, -80.0}, kSilence_db), std::nullopt);
  EXPECT_EQ(loudest_microphone({}, kSilence_db), std::nullopt);
}

}  // namespace
}  // namespace earpoint
