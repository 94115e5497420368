#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/generate_testing/quick_generation.h>
#include <earpoint/record_simulation/session_plan.h>

namespace earpoint {
namespace {

/// Sessions in two rooms, planned once for all tests.
class SessionPlanTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TestFolder>("session_plan_test");
    corpus_ = std::make_unique<SpeechCorpus>(
        SpeechCorpus::load(write_test_corpus(folder_->path() / "speech")));
    scene_ = prepare_home("two rooms", two_rooms());
    figures_ = std::make_unique<FigureLibrary>();
    for (std::uint64_t seed = 1; seed <= 3; ++seed) plans_.push_back(plan(seed));
  }
  static void TearDownTestSuite() {
    plans_.clear();
    figures_.reset();
    scene_.reset();
    corpus_.reset();
    folder_.reset();
  }

  static SessionPlan plan(std::uint64_t seed) {
    RandomStream random(seed);
    return plan_session(*scene_, *figures_, *corpus_, DataSplit::test, options_, random);
  }

  static inline const SessionOptions options_{.people = 2, .duration_s = 120.0};
  static inline std::unique_ptr<TestFolder> folder_;
  static inline std::unique_ptr<SpeechCorpus> corpus_;
  static inline std::shared_ptr<const PreparedScene> scene_;
  static inline std::unique_ptr<FigureLibrary> figures_;
  static inline std::vector<SessionPlan> plans_;
};

TEST_F(SessionPlanTest, CamerasStandAroundThePeopleAndLookInwards) {
  for (const SessionPlan& plan : plans_) {
    ASSERT_EQ(plan.world_from_camera.size(), 8U);
    std::vector<double> angles_rad;
    for (const Pose& camera : plan.world_from_camera) {
      for (const SessionFigure& person : plan.people) {
        const Vector3 seen =
            transform_point(inverse(camera), person.world_from_mouth(0.0).position_m);
        EXPECT_GT(seen.x, 0.0) << "behind a camera";
      }
      EXPECT_GE(scene_->floor.clearance_m({camera.position_m.x, camera.position_m.y}), 0.2);
      const Vector3 front = rotate(camera.orientation, {1, 0, 0});
      angles_rad.push_back(std::atan2(front.y, front.x));
    }
    std::ranges::sort(angles_rad);
    for (std::size_t i = 1; i < angles_rad.size(); ++i) {
      // 45 degrees less up to a quarter of it at either end.
      EXPECT_GE(angles_rad[i] - angles_rad[i - 1], radians_from_degrees(45.0 * 0.5) - 1e-9);
    }
  }
}

TEST_F(SessionPlanTest, NobodyWalksIntoAnybody) {
  int walks = 0;
  for (const SessionPlan& plan : plans_) {
    for (double time_s = 0.0; time_s < plan.duration_s; time_s += 0.1) {
      const FloorPoint a = plan.people[0].path.at(time_s).at;
      const FloorPoint b = plan.people[1].path.at(time_s).at;
      // Paths are tested every 0.1 m: at most half of that can be missed.
      EXPECT_GE(distance_m(a, b), 0.8 - 0.06) << time_s;
      for (const Pose& camera : plan.world_from_camera) {
        EXPECT_GE(distance_m(a, {camera.position_m.x, camera.position_m.y}), 0.75 - 0.06);
      }
      EXPECT_GT(scene_->floor.clearance_m(a), 0.25);
    }
    for (const SessionFigure& person : plan.people) {
      walks += static_cast<int>(person.path.moving().size());
    }
  }
  // Five a minute, without those for which nobody stands or no way was found.
  EXPECT_GE(walks, 8);
  EXPECT_LE(walks, 40);
}

TEST_F(SessionPlanTest, PeopleTakeTurnsAndNobodySpeaksTwiceAtOnce) {
  for (const SessionPlan& plan : plans_) {
    std::vector<double> free_s(plan.people.size(), plan.clap_s);
    std::vector<double> spoken_s(plan.people.size());
    for (const Utterance& turn : plan.turns) {
      EXPECT_GE(turn.begin_s, free_s[turn.person]);
      free_s[turn.person] = turn.begin_s + turn.speech.duration_s();
      EXPECT_LE(free_s[turn.person], plan.duration_s);
      spoken_s[turn.person] += turn.speech.duration_s();
    }
    for (const double spoken : spoken_s) EXPECT_GT(spoken, 0.15 * plan.duration_s);
  }
}

TEST_F(SessionPlanTest, VoicesAreThoseOfTheSplit) {
  for (const SessionPlan& plan : plans_) {
    EXPECT_NE(plan.people[0].voice->name, plan.people[1].voice->name);
    for (const SessionFigure& person : plan.people) {
      EXPECT_EQ(person.voice->split, DataSplit::test);
      EXPECT_EQ(person.voice->gender, person.figure->gender);
      EXPECT_GE(norm(person.microphone_m), 0.10);
      EXPECT_LE(norm(person.microphone_m), 0.20);
    }
  }
  SessionOptions four = options_;
  four.people = 4;
  RandomStream random(1);
  // The corpus has one test voice per gender.
  EXPECT_THROW((void)plan_session(*scene_, *figures_, *corpus_, DataSplit::test, four, random),
               InputError);
}

TEST_F(SessionPlanTest, ClocksStayWithinTheOptions) {
  for (const SessionPlan& plan : plans_) {
    ASSERT_EQ(plan.clocks.size(), 10U);
    for (std::size_t i = 0; i < plan.clocks.size(); ++i) {
      const DeviceClock& clock = plan.clocks[i];
      EXPECT_GE(clock.offset_s, 0.0);
      EXPECT_LE(clock.offset_s, options_.most_offset_s + 0.01);
      EXPECT_LT(clock.offset_s, plan.clap_s) << "a device misses the clap";
      EXPECT_LE(std::abs(clock.drift_ppm), options_.most_drift_ppm);
      if (i >= plan.world_from_camera.size()) continue;
      const double frames = clock.offset_s * options_.frame_rate_hz;
      EXPECT_LT(frames - std::floor(frames), 0.01 * options_.frame_rate_hz + 1e-9);
    }
  }
}

TEST_F(SessionPlanTest, TheSameSeedGivesTheSameSession) {
  const SessionPlan again = plan(2);
  EXPECT_EQ(again.clocks, plans_[1].clocks);
  EXPECT_EQ(again.world_from_camera, plans_[1].world_from_camera);
  EXPECT_NE(plans_[0].clocks, plans_[1].clocks);
  ASSERT_EQ(again.turns.size(), plans_[1].turns.size());
  for (std::size_t i = 0; i < again.people.size(); ++i) {
    EXPECT_EQ(track_of(again.people[i], 120.0), track_of(plans_[1].people[i], 120.0));
  }
}

TEST(SpeechIntervals, LeaveOutSilence) {
  Utterance turn{.person = 0, .begin_s = 5.0, .speech = Waveform(1, 3 * 16000, 16000)};
  for (std::ptrdiff_t i = 16000 / 2; i < 16000; ++i) turn.speech.channel(0)[i] = 0.1F;
  for (std::ptrdiff_t i = 2 * 16000; i < 16000 * 5 / 2; ++i) turn.speech.channel(0)[i] = 0.1F;
  const std::vector<SpeechInterval> intervals = speech_intervals(turn);
  ASSERT_EQ(intervals.size(), 2U);
  // Speech intervals are in blocks of 20 ms.
  EXPECT_NEAR(intervals[0].begin_s, 5.5, 0.021);
  EXPECT_NEAR(intervals[0].end_s, 6.0, 0.021);
  EXPECT_NEAR(intervals[1].begin_s, 7.0, 0.021);
  EXPECT_NEAR(intervals[1].end_s, 7.5, 0.021);
}

}  // namespace
}  // namespace earpoint
