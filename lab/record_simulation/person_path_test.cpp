#include "turn_pieces.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include <earpoint/pose.h>
#include <earpoint/record_simulation/person_path.h>

namespace earpoint {
namespace {

PersonPath path_with_two_walks() {
  PersonPath path({{1.0, 1.0}, 3.0});
  path.add({.begin_s = 2.0,
            .from = {1.0, 1.0},
            .to = {3.0, 1.5},
            .yaw_before_rad = 3.0,
            .yaw_after_rad = -3.0});
  path.add({.begin_s = 9.0,
            .from = {3.0, 1.5},
            .to = {2.0, 2.5},
            .yaw_before_rad = -3.0,
            .yaw_after_rad = 1.0});
  return path;
}

TEST(PersonPath, WalksWithoutAJumpOfPlaceOrSpeed) {
  const PersonPath path = path_with_two_walks();
  constexpr double kStep_s = 0.01;
  double speed_before = 0.0;
  for (double time_s = 0.0; time_s < 15.0; time_s += kStep_s) {
    const Stance now = path.at(time_s);
    const Stance next = path.at(time_s + kStep_s);
    const double speed = distance_m(now.at, next.at) / kStep_s;
    // A minimum-jerk path of 0.8 m/s on average has 1.875 times that in its middle.
    EXPECT_LE(speed, 0.8 * 1.875 + 0.01);
    // Such a path has an acceleration of 5.8 distance / duration^2 at most: 2.3 m/s2 for these
    // walks.
    EXPECT_LE(std::abs(speed - speed_before), 3.0 * kStep_s) << time_s;
    // At most half a turn in 0.6 s, on the same course.
    EXPECT_LE(std::abs(wrap_angle(next.yaw_rad - now.yaw_rad)), 1.875 * kPi / 0.6 * kStep_s);
    speed_before = speed;
  }
  EXPECT_EQ(path.at(0.0), (Stance{{1.0, 1.0}, 3.0}));
  EXPECT_EQ(path.at(100.0), (Stance{{2.0, 2.5}, 1.0}));
}

TEST(PersonPath, LooksWhereItGoes) {
  const PersonPath path = path_with_two_walks();
  EXPECT_NEAR(path.at(2.0 + 1.8).yaw_rad, std::atan2(0.5, 2.0), 1e-12);
}

TEST(PersonPath, KnowsWhenItMoves) {
  const PersonPath path = path_with_two_walks();
  const std::vector<Span> moving = path.moving();
  ASSERT_EQ(moving.size(), 2U);
  EXPECT_EQ(moving[0].begin_s, 2.0);
  EXPECT_NEAR(moving[0].end_s, 2.0 + 1.2 + std::hypot(2.0, 0.5) / 0.8, 1e-12);
  EXPECT_EQ(path.at(moving[0].end_s - 1e-9).at.x, path.at(moving[0].end_s).at.x);
  EXPECT_TRUE(path.moves_in({1.0, 2.1}));
  EXPECT_FALSE(path.moves_in({1.0, 2.0}));
}

TEST(PersonPath, RefusesAWalkThatBeginsElsewhereOrTooEarly) {
  PersonPath path = path_with_two_walks();
  EXPECT_THROW(path.add({.begin_s = 20.0,
                         .from = {0.0, 0.0},
                         .to = {1.0, 0.0},
                         .yaw_before_rad = 1.0,
                         .yaw_after_rad = 0.0}),
               std::logic_error);
  EXPECT_THROW(path.add({.begin_s = 9.5,
                         .from = {2.0, 2.5},
                         .to = {1.0, 0.0},
                         .yaw_before_rad = 1.0,
                         .yaw_after_rad = 0.0}),
               std::logic_error);
}

TEST(TurnPieces, AddUpToTheSpeechAndMoveOnlyWhereSomebodyMoves) {
  Waveform speech(1, 16000 * 8, 16000);
  for (std::ptrdiff_t i = 0; i < speech.samples(); ++i) {
    speech.channel(0)[i] = static_cast<float>(std::sin(0.05 * static_cast<double>(i)));
  }
  const double begin_s = 10.0;
  const std::vector<Span> moves = {{15.5, 16.0}, {12.0, 13.0}, {12.5, 13.5}, {30.0, 31.0}};
  const std::vector<TurnPiece> pieces = cut_turn(speech, begin_s, moves);
  ASSERT_EQ(pieces.size(), 5U);
  std::vector<double> sum(static_cast<std::size_t>(speech.samples()));
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    EXPECT_EQ(pieces[p].moves, p % 2 == 1);
    const auto first = std::lround((pieces[p].begin_s - begin_s) * 16000);
    for (std::size_t i = 0; i < pieces[p].speech.size(); ++i) {
      sum[static_cast<std::size_t>(first) + i] += pieces[p].speech[i];
    }
    if (pieces[p].moves) continue;
    // A still piece overlaps no motion.
    const Span span{pieces[p].begin_s,
                    pieces[p].begin_s + static_cast<double>(pieces[p].speech.size()) / 16000};
    for (const Span& move : moves) {
      EXPECT_TRUE(span.end_s < move.begin_s || span.begin_s > move.end_s);
    }
  }
  for (std::ptrdiff_t i = 0; i < speech.samples(); ++i) {
    // Rounding of two float products.
    EXPECT_NEAR(sum[static_cast<std::size_t>(i)], speech.channel(0)[i], 2e-7);
  }
}

TEST(TurnPieces, SpeechWithoutMotionIsOnePiece) {
  const Waveform speech(1, 16000, 16000);
  const std::vector<TurnPiece> pieces = cut_turn(speech, 3.0, {{0.0, 2.0}, {5.0, 6.0}});
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_FALSE(pieces[0].moves);
  EXPECT_EQ(std::ssize(pieces[0].speech), speech.samples());
}

}  // namespace
}  // namespace earpoint
