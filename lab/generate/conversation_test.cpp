#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/audio/gcc_phat.h>
#include <earpoint/error.h>
#include <earpoint/generate/conversation.h>
#include <earpoint/generate_testing/quick_generation.h>
#include <earpoint/spatial/air_absorption.h>

namespace earpoint {
namespace {

ConversationQuality quick_quality() {
  ConversationQuality quality;
  quality.rays = 200;
  quality.duration_s = 0.3;
  quality.image_width = 128;
  quality.image_height = 128;
  quality.samples_per_side = 1;
  return quality;
}

/// Conversations in two rooms, planned and simulated once for all tests.
class ConversationTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    scene_ = prepare_home("two rooms", two_rooms());
    figures_ = std::make_unique<FigureLibrary>();
    const ConversationSimulator simulator(quick_quality());
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      RandomStream random(seed);
      plans_.push_back(plan_conversation(scene_->floor, scene_->caster, *figures_,
                                         FigureSplit::train, options_, "two rooms", random));
      StageClock clock;
      conversations_.push_back(simulator.simulate(*scene_, plans_.back(), seed, clock));
    }
  }
  static void TearDownTestSuite() {
    conversations_.clear();
    plans_.clear();
    figures_.reset();
    scene_.reset();
  }

  /// Calls check(viewpoint, person, conversation's index, person's index) for all pairs.
  template <typename Check>
  static void for_all_pairs(Check check) {
    for (std::size_t c = 0; c < conversations_.size(); ++c) {
      for (const SimulatedViewpoint& viewpoint : conversations_[c].viewpoints) {
        for (std::size_t i = 0; i < 2; ++i) check(viewpoint, conversations_[c].people[i], c, i);
      }
    }
  }

  static bool is_seen(const SimulatedViewpoint& viewpoint, const Person& person) {
    return sees(scene_->caster, viewpoint.world_from_listener.position_m,
                person.world_from_head.position_m);
  }

  /// Direction and distance of the mouth from the listener.
  static Spherical direction_of(const SimulatedViewpoint& viewpoint, const Person& person) {
    return spherical_from_cartesian(
        transform_point(inverse(viewpoint.world_from_listener), person.world_from_head.position_m));
  }

  /// The picture shows the person, and neither scene nor bodies are in the way.
  static bool is_in_plain_sight(const SimulatedViewpoint& viewpoint, const Person& person,
                                std::size_t i) {
    return viewpoint.boxes[i] && is_seen(viewpoint, person);
  }

  // Viewpoints in both rooms, so that the wall hides some speakers.
  static inline const ConversationOptions options_{.viewpoint_reach_m = 4.5};
  static inline std::shared_ptr<const PreparedScene> scene_;
  static inline std::unique_ptr<FigureLibrary> figures_;
  static inline std::vector<ConversationPlan> plans_;
  static inline std::vector<SimulatedConversation> conversations_;
};

TEST_F(ConversationTest, AWomanAndAManSeeEachOtherWithinThreeMetres) {
  for (const SimulatedConversation& conversation : conversations_) {
    const auto& [a, b] = conversation.people;
    EXPECT_NE(a.gender, b.gender);
    const Vector3 way = b.world_from_head.position_m - a.world_from_head.position_m;
    EXPECT_LE(norm(way), 3.0);
    EXPECT_TRUE(sees(scene_->caster, a.world_from_head.position_m, b.world_from_head.position_m));
    // They look at each other, within three standard deviations of 20 degrees.
    const Vector3 front = rotate(a.world_from_head.orientation, {1, 0, 0});
    EXPECT_GE(dot(front, normalized(Vector3{way.x, way.y, 0})), std::cos(radians_from_degrees(61)));
  }
}

TEST_F(ConversationTest, ThePlanKnowsWhereMouthsWillBe) {
  for (std::size_t c = 0; c < plans_.size(); ++c) {
    for (std::size_t i = 0; i < 2; ++i) {
      const Pose planned = plans_[c].people[i].world_from_mouth();
      const Pose made = conversations_[c].people[i].world_from_head;
      EXPECT_NEAR(norm(planned.position_m - made.position_m), 0.0, 1e-9);
    }
  }
}

TEST_F(ConversationTest, ViewpointsStandFreeAtOneAndAHalfMetresAndFaceTheMiddle) {
  for (const SimulatedConversation& conversation : conversations_) {
    const Vector3 middle = (conversation.people[0].world_from_head.position_m +
                            conversation.people[1].world_from_head.position_m) /
                           2.0;
    for (const SimulatedViewpoint& viewpoint : conversation.viewpoints) {
      const Pose& pose = viewpoint.world_from_listener;
      EXPECT_DOUBLE_EQ(pose.position_m.z, 1.5);
      EXPECT_GE(scene_->floor.clearance_m({pose.position_m.x, pose.position_m.y}), 0.25);
      const Vector3 seen = transform_point(inverse(pose), middle);
      EXPECT_NEAR(std::atan2(seen.y, seen.x), 0.0, 1e-9);
      // Level: up is up.
      EXPECT_NEAR(rotate(pose.orientation, {0, 0, 1}).z, 1.0, 1e-12);
    }
  }
}

TEST_F(ConversationTest, SomeSpeakersAreHiddenByTheWallAndHaveNoBox) {
  int behind_wall = 0;
  for_all_pairs([&](const auto& viewpoint, const Person& person, std::size_t, std::size_t i) {
    if (is_seen(viewpoint, person)) return;
    ++behind_wall;
    // Of a person whose mouth is hidden, only an arm or a leg is visible.
    if (!viewpoint.boxes[i]) return;
    EXPECT_LT(viewpoint.boxes[i]->x_max - viewpoint.boxes[i]->x_min, 0.3);
  });
  EXPECT_GE(behind_wall, 1);
}

TEST_F(ConversationTest, DirectSoundArrivesAfterDistanceOverSpeedOfSound) {
  const double speed_m_per_s = speed_of_sound_m_per_s(Air{});
  int checked = 0;
  for_all_pairs([&](const auto& viewpoint, const Person& person, std::size_t, std::size_t i) {
    if (!is_in_plain_sight(viewpoint, person, i)) return;
    const Waveform& response = viewpoint.responses[i];
    const double travel_s = direction_of(viewpoint, person).distance_m / speed_m_per_s;
    // The ear on the speaker's side is up to 0.1 m nearer, and pulses of 8 kHz are 0.1 ms wide.
    const auto first = static_cast<std::ptrdiff_t>((travel_s - 0.0004) * 16000.0);
    const auto last = static_cast<std::ptrdiff_t>((travel_s + 0.0006) * 16000.0);
    float before = 0.0F;
    float around = 0.0F;
    for (int ear = 0; ear < 2; ++ear) {
      const auto samples = response.channel(ear);
      for (std::ptrdiff_t t = 0; t < last; ++t) {
        float& peak = t < first ? before : around;
        peak = std::max(peak, std::abs(samples[t]));
      }
    }
    // Filters ring ahead of the arrival, at least 12 dB down; nothing else may come earlier.
    EXPECT_GT(around, 4.0F * before);
    EXPECT_GT(around, 0.0F);
    ++checked;
  });
  EXPECT_GE(checked, 8);
}

TEST_F(ConversationTest, NothingIsHeardBeforeTheStraightWaysTime) {
  const double speed_m_per_s = speed_of_sound_m_per_s(Air{});
  for_all_pairs([&](const auto& viewpoint, const Person& person, std::size_t, std::size_t i) {
    const double travel_s = direction_of(viewpoint, person).distance_m / speed_m_per_s;
    const auto silent = static_cast<std::ptrdiff_t>((travel_s - 0.002) * 16000.0);
    for (int ear = 0; ear < 2; ++ear) {
      const auto samples = viewpoint.responses[i].channel(ear);
      for (std::ptrdiff_t t = 0; t < silent; ++t) ASSERT_EQ(samples[t], 0.0F);
    }
  });
}

TEST_F(ConversationTest, SoundComesFirstToTheEarOnTheSpeakersSide) {
  const double speed_m_per_s = speed_of_sound_m_per_s(Air{});
  int checked = 0;
  for_all_pairs([&](const auto& viewpoint, const Person& person, std::size_t, std::size_t i) {
    const Spherical direction = direction_of(viewpoint, person);
    // Close to straight ahead the ears do not differ.
    if (!is_in_plain_sight(viewpoint, person, i)) return;
    if (std::abs(std::sin(direction.azimuth_rad)) < 0.2) return;
    // The direct sound alone: a millisecond and a half from its arrival.
    const auto start =
        static_cast<std::ptrdiff_t>((direction.distance_m / speed_m_per_s - 0.0005) * 16000.0);
    const Waveform& response = viewpoint.responses[i];
    const double delay = gcc_phat_delay_samples(response.channel(0).subspan(start, 24),
                                                response.channel(1).subspan(start, 24), 16.0);
    // Positive: the left ear hears later, so the speaker is to the right.
    EXPECT_EQ(delay<0.0, direction.azimuth_rad> 0.0)
        << "delay " << delay << " azimuth " << degrees_from_radians(direction.azimuth_rad);
    ++checked;
  });
  EXPECT_GE(checked, 4);
}

TEST_F(ConversationTest, TheBoxIsWhereTheHeadIsSeen) {
  const ConversationQuality quality = quick_quality();
  int checked = 0;
  for_all_pairs([&](const auto& viewpoint, const Person& person, std::size_t, std::size_t i) {
    if (!is_in_plain_sight(viewpoint, person, i)) return;
    const Camera camera{.world_from_camera = viewpoint.world_from_listener,
                        .horizontal_fov_rad = quality.horizontal_fov_rad,
                        .width = quality.image_width,
                        .height = quality.image_height};
    const auto mouth = project(camera, person.world_from_head.position_m);
    ASSERT_TRUE(mouth);
    const Box& box = *viewpoint.boxes[i];
    const double x = mouth->x / camera.width;
    const double y = mouth->y / camera.height;
    if (x < 0.0 || x > 1.0) return;  // an arm is in the picture, the head is not
    // The mouth is 2 cm in front of the lips: seen from the side, just outside the body.
    const double margin = 0.05 / direction_of(viewpoint, person).distance_m;
    EXPECT_GE(x, box.x_min - margin);
    EXPECT_LE(x, box.x_max + margin);
    EXPECT_GE(y, box.y_min - margin);
    EXPECT_LE(y, box.y_max + margin);
    ++checked;
  });
  EXPECT_GE(checked, 8);
}

TEST_F(ConversationTest, ASpeakersOwnBodyIsNotInTheWay) {
  // In front of a visible speaker the direct sound has at least the level of speech at that
  // distance less the directivity at 90 degrees: the body takes nothing away.
  int checked = 0;
  for_all_pairs([&](const auto& viewpoint, const Person& person, std::size_t, std::size_t i) {
    if (!is_in_plain_sight(viewpoint, person, i)) return;
    const Vector3 to_listener =
        transform_point(inverse(person.world_from_head), viewpoint.world_from_listener.position_m);
    if (to_listener.x <= 0.0) return;
    float peak = 0.0F;
    for (const float sample : viewpoint.responses[i].planar())
      peak = std::max(peak, std::abs(sample));
    EXPECT_GT(peak, 0.1 / norm(to_listener));
    ++checked;
  });
  EXPECT_GE(checked, 4);
}

TEST(ConversationPlan, SomeViewpointsStandInOtherRoomsAndAtOtherHeights) {
  const auto rooms = prepare_home("two rooms", two_rooms());
  const FigureLibrary figures;
  constexpr int kPlans = 30;
  constexpr ConversationOptions kOptions{.viewpoints = 5,
                                         .hidden_share = 0.0,
                                         .other_room_share = 0.5,
                                         .other_room_reach_m = 7.0,
                                         .height_spread_m = 0.2};
  int away = 0;
  double lowest_m = 9.0;
  double highest_m = 0.0;
  for (std::uint64_t seed = 1; seed <= kPlans; ++seed) {
    RandomStream random(seed);
    const ConversationPlan plan = plan_conversation(
        rooms->floor, rooms->caster, figures, FigureSplit::train, kOptions, "two rooms", random);
    ASSERT_EQ(plan.viewpoints.size(), 5U);
    for (const Pose& viewpoint : plan.viewpoints) {
      const Vector3 at = viewpoint.position_m;
      EXPECT_GE(rooms->floor.clearance_m({at.x, at.y}), 0.25);
      lowest_m = std::min(lowest_m, at.z);
      highest_m = std::max(highest_m, at.z);
      bool sees_one = false;
      for (const PlannedPerson& person : plan.people) {
        sees_one = sees_one || sees(rooms->caster, at, person.world_from_mouth().position_m);
      }
      if (sees_one) continue;
      ++away;
      EXPECT_NE(&viewpoint, plan.viewpoints.data()) << "the first stays with the people";
    }
  }
  // 60 +- 5.5 of the 120 that may be in another room, less those whose other room is out of reach.
  EXPECT_GT(away, 35);
  EXPECT_LT(away, 80);
  EXPECT_GE(lowest_m, 1.3);
  EXPECT_LT(lowest_m, 1.35);
  EXPECT_LE(highest_m, 1.7);
  EXPECT_GT(highest_m, 1.65);
}

TEST(ConversationPlan, ASceneWithoutRoomIsRefused) {
  const auto closet =
      prepare_home("closet", make_shoebox({1.5, 1.8, 2.5}, all_bands(0.2F), all_bands(0.2F)));
  RandomStream random(1);
  EXPECT_THROW(static_cast<void>(plan_conversation(closet->floor, closet->caster, FigureLibrary(),
                                                   FigureSplit::train, {}, "closet", random)),
               InputError);
}

TEST(PreparedScene, AScanIsMovedOntoItsFloor) {
  Scene scene = two_rooms();
  for (auto& position : scene.mesh.positions) position[2] -= 1.25F;
  const auto prepared = prepare_scan("scan", std::move(scene));
  // Two roundings of floats of up to 2.5 m; the floor is the mean of many points.
  EXPECT_NEAR(bounds(prepared->scene.mesh).low.z, 0.0, 1e-5);
  EXPECT_NEAR(prepared->floor.floor_m(), 0.0, 1e-5);
}

}  // namespace
}  // namespace earpoint
