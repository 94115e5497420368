#include <cmath>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/locate/active_speaker.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/binaural.h>

namespace earpoint {
namespace {

constexpr double kFov_rad = radians_from_degrees(90.0);

SpeakerMoment moment(std::vector<int> tracks, std::vector<double> likelihoods, double outside = 0.1,
                     double power = 1e-3) {
  return {.tracks = std::move(tracks),
          .likelihoods = std::move(likelihoods),
          .outside = outside,
          .power = power};
}

TEST(DirectionOfBox, IsThatOfAPinholeCamera) {
  const Box left_edge{.x_min = 0.0, .y_min = 0.2, .x_max = 1e-9, .y_max = 0.9};
  EXPECT_NEAR(direction_of_box(left_edge, kFov_rad).azimuth_rad, kPi / 4, 1e-6);
  const Box middle{.x_min = 0.4, .y_min = 0.2, .x_max = 0.6, .y_max = 0.9};
  EXPECT_NEAR(direction_of_box(middle, kFov_rad).azimuth_rad, 0.0, 1e-12);
  EXPECT_GT(direction_of_box(middle, kFov_rad).spread_rad,
            direction_of_box(left_edge, kFov_rad).spread_rad);
}

TEST(ActiveSpeakers, FollowTurnsAndJoinWeakEvidenceOverTime) {
  // Two turns of 4 s. Each moment is only weak evidence for the right person, one in five against.
  std::vector<SpeakerMoment> moments;
  for (int i = 0; i < 40; ++i) {
    const bool says_first = (i < 20) != (i % 5 == 2);
    moments.push_back(says_first ? moment({3, 8}, {1.0, 0.35}) : moment({3, 8}, {0.35, 1.0}));
  }
  const auto beliefs = active_speakers(moments);
  for (int i = 0; i < 40; ++i) {
    if (std::abs(i - 20) < 3) continue;  // the end of a turn is known only roughly
    EXPECT_GT(beliefs[i].people[i < 20 ? 0 : 1], 0.8) << i;
    EXPECT_NEAR(beliefs[i].people[0] + beliefs[i].people[1] + beliefs[i].outside, 1.0, 1e-12);
  }
}

TEST(ActiveSpeakers, SayThatTheSpeakerIsNotInThePicture) {
  const std::vector<SpeakerMoment> behind(10, moment({0, 1}, {0.01, 0.02}, 1.0));
  EXPECT_GT(active_speakers(behind)[5].outside, 0.95);
  const std::vector<SpeakerMoment> nobody(3, moment({}, {}));
  EXPECT_EQ(active_speakers(nobody)[1].outside, 1.0);
  // With one person and no direction in the sound, it is most likely that person.
  const std::vector<SpeakerMoment> mono(5, moment({0}, {1.0}, 1.0));
  EXPECT_NEAR(active_speakers(mono)[2].people[0], 0.9, 1e-9);
}

TEST(ActiveSpeakers, GoOnOutsideWhenTheirTrackEnds) {
  std::vector<SpeakerMoment> moments(10, moment({0, 1}, {1.0, 0.01}));
  for (int i = 0; i < 5; ++i) moments.push_back(moment({1}, {0.01}, 1.0));
  const auto beliefs = active_speakers(moments);
  EXPECT_GT(beliefs[8].people[0], 0.95);
  EXPECT_GT(beliefs[12].outside, 0.95);
}

TEST(ActiveSpeakers, KnowSilence) {
  std::vector<SpeakerMoment> moments(20, moment({0}, {1.0}));
  moments[10].power = 1e-8;  // 50 dB below
  const auto beliefs = active_speakers(moments);
  EXPECT_GT(beliefs[5].voice, 0.99);
  EXPECT_LT(beliefs[10].voice, 0.01);
  const std::vector<SpeakerMoment> silent(5, moment({0}, {1.0}, 1.0, 0.0));
  EXPECT_LT(active_speakers(silent)[0].voice, 0.01);
  EXPECT_TRUE(active_speakers({}).empty());
}

TEST(SpeakerMomentTest, TellsPeopleApartWhoAreFifteenDegreesApart) {
  const HrtfSet head = HrtfSet::load(VoiceDirection::kSampleRateHz);
  RandomStream random(4);
  std::vector<float> voice(16000);
  for (std::size_t i = 0; i < voice.size(); ++i) {
    const double envelope = std::pow(std::sin(static_cast<double>(i) / 900.0), 4.0);
    voice[i] = static_cast<float>(0.1 * envelope * random.normal());
  }
  // Boxes 0.1 wide whose middles lie at -10 and 5 degrees, and a third at 30.
  std::vector<TrackedPerson> people;
  for (const double azimuth_deg : {-10.0, 5.0, 30.0}) {
    const double x = 0.5 - 0.5 * std::tan(radians_from_degrees(azimuth_deg));
    people.push_back({.track = static_cast<int>(people.size()),
                      .box = {.x_min = x - 0.05, .y_min = 0.3, .x_max = x + 0.05, .y_max = 0.9}});
  }
  const auto hear = [&](double azimuth_deg) {
    VoiceDirection direction(head);
    const Spherical place{.azimuth_rad = radians_from_degrees(azimuth_deg), .distance_m = 1.5};
    const std::vector<SpeakerMoment> moments{
        speaker_moment(people, direction.listen(pan_binaural(voice, head, place)), kFov_rad)};
    return active_speakers(moments)[0];
  };
  EXPECT_GT(hear(-10.0).people[0], 0.9);
  EXPECT_GT(hear(5.0).people[1], 0.9);
  EXPECT_GT(hear(30.0).people[2], 0.9);
  EXPECT_GT(hear(75.0).outside, 0.9);
}

}  // namespace
}  // namespace earpoint
