#include <cmath>
#include <optional>
#include <set>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/locate/person_tracker.h>

namespace earpoint {
namespace {

constexpr double kStep_s = 0.2;

Box person_at(double x, double y = 0.5, double height = 0.5) {
  return {.x_min = x - 0.15 * height,
          .y_min = y - 0.5 * height,
          .x_max = x + 0.15 * height,
          .y_max = y + 0.5 * height};
}

/// Two people who walk past each other; the nearer one (number 0) hides the other while they
/// overlap by half a width.
struct Crossing {
  std::vector<std::vector<TrackedPerson>> truth;
  std::vector<std::vector<DetectedPerson>> found;

  explicit Crossing(std::uint64_t seed) {
    RandomStream random(seed);
    for (int i = 0; i < 40; ++i) {
      const double x[] = {0.15 + 0.0175 * i, 0.85 - 0.0175 * i};
      const double tall[] = {0.6, 0.5};
      truth.emplace_back();
      found.emplace_back();
      for (int person = 0; person < 2; ++person) {
        const Box box = person_at(x[person], 0.5, tall[person]);
        truth.back().push_back({.track = person, .box = box});
        const bool is_hidden = person == 1 && std::abs(x[0] - x[1]) < 0.08;
        if (is_hidden || random.uniform() < 0.1) continue;
        Box jittered = box;
        for (double* edge : {&jittered.x_min, &jittered.y_min, &jittered.x_max, &jittered.y_max}) {
          *edge += 0.01 * random.normal();
        }
        found.back().push_back({jittered, 0.9});
      }
    }
  }
};

TEST(PersonTracker, KeepsIdentitiesWhenPeopleCrossAndAreHiddenAndMissed) {
  int switches = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Crossing crossing(seed);
    PersonTracker tracker;
    std::vector<std::vector<TrackedPerson>> tracked;
    for (std::size_t i = 0; i < crossing.found.size(); ++i) {
      tracked.push_back(tracker.update(kStep_s * static_cast<double>(i), crossing.found[i]));
    }
    switches += count_identity_switches(crossing.truth, tracked);
  }
  // 20 crossings, each with two switches if there were no prediction.
  EXPECT_LE(switches, 2);
}

TEST(PersonTracker, CarriesOnWhoIsHiddenAndForgetsThemLater) {
  PersonTracker tracker;
  const auto show = [&](int step, std::optional<double> x) {
    std::vector<DetectedPerson> people;
    if (x) people.push_back({person_at(*x), 0.8});
    return tracker.update(kStep_s * step, people);
  };
  int step = 0;
  for (; step < 10; ++step) ASSERT_EQ(show(step, 0.2 + 0.02 * step).size(), 1U);
  for (; step < 13; ++step) {
    const auto hidden = show(step, std::nullopt);
    ASSERT_EQ(hidden.size(), 1U);
    EXPECT_FALSE(hidden[0].is_seen);
    // The person goes on by 0.02 a picture; the filter's speed lags by a few per cent.
    EXPECT_NEAR(0.5 * (hidden[0].box.x_min + hidden[0].box.x_max), 0.2 + 0.02 * step, 0.02);
  }
  const auto back = show(step, 0.2 + 0.02 * step);
  ASSERT_EQ(back.size(), 1U);
  EXPECT_EQ(back[0].track, 0);
  EXPECT_TRUE(back[0].is_seen);
  for (int i = 0; i < 9; ++i) (void)show(++step, std::nullopt);
  EXPECT_TRUE(show(++step, std::nullopt).empty());
  (void)show(++step, 0.5);
  const auto later = show(++step, 0.5);
  ASSERT_EQ(later.size(), 1U);
  EXPECT_EQ(later[0].track, 1) << "a number is not given twice";
}

TEST(PersonTracker, TakesASingleFalseDetectionForNobody) {
  PersonTracker tracker;
  const DetectedPerson person{person_at(0.3), 0.9};
  const DetectedPerson ghost{person_at(0.8), 0.5};
  EXPECT_EQ(tracker.update(0.0, std::vector{person}).size(), 1U);
  EXPECT_EQ(tracker.update(0.2, std::vector{person, ghost}).size(), 1U);
  EXPECT_EQ(tracker.update(0.4, std::vector{person}).size(), 1U);
  EXPECT_EQ(tracker.update(0.6, std::vector{person, ghost}).size(), 1U);
  EXPECT_EQ(tracker.update(0.8, std::vector{person, ghost}).size(), 2U);
}

TEST(CountIdentitySwitches, CountsWhoGetsAnotherNumberAndNotWhoIsLost) {
  const auto at = [](int track, double x) {
    return TrackedPerson{.track = track, .box = person_at(x)};
  };
  const std::vector<std::vector<TrackedPerson>> truth{
      {at(0, 0.2), at(1, 0.8)}, {at(0, 0.2), at(1, 0.8)}, {at(0, 0.2), at(1, 0.8)}};
  EXPECT_EQ(count_identity_switches(truth, truth), 0);
  const std::vector<std::vector<TrackedPerson>> swapped{
      {at(5, 0.2), at(7, 0.8)}, {at(7, 0.2), at(5, 0.8)}, {at(7, 0.2)}};
  EXPECT_EQ(count_identity_switches(truth, swapped), 2);
}

}  // namespace
}  // namespace earpoint
