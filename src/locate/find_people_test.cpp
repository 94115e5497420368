#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/random.h>
#include <earpoint/locate/find_people.h>
#include <earpoint/locate/plot_people.h>
#include <earpoint/media/image_file.h>
#include <earpoint/media/media.h>
#include <earpoint/pose.h>
#include <earpoint/spatial/binaural.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr int kRate_hz = 16000;
constexpr double kFov_rad = kPi / 2;

/// Finds the given people in any picture.
class ToldDetector : public PeopleDetector {
 public:
  explicit ToldDetector(std::vector<DetectedPerson> people) : people_(std::move(people)) {}
  std::vector<DetectedPerson> detect(const Image& /*picture*/) override {
    ++looks;
    return people_;
  }
  [[nodiscard]] std::string name() const override { return "told"; }

  int looks = 0;

 private:
  std::vector<DetectedPerson> people_;
};

Box box_at(double azimuth_deg) {
  const double x = 0.5 - 0.5 * std::tan(radians_from_degrees(azimuth_deg));
  return {.x_min = x - 0.05, .y_min = 0.3, .x_max = x + 0.05, .y_max = 0.9};
}

class FindPeople : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(testing::TempDir()) / ("find_people_" + name);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write_image(folder_ / "frame.png", Image(64, 48, 3, 90));
    source_.picture = folder_ / "frame.png";
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Two seconds from every azimuth, one after the other.
  void speak_from(const std::vector<double>& azimuths_deg) {
    const HrtfSet head = HrtfSet::load(kRate_hz);
    RandomStream random(6);
    const std::ptrdiff_t turn = 2 * kRate_hz;
    Waveform sound(2, turn * std::ssize(azimuths_deg), kRate_hz);
    for (std::size_t i = 0; i < azimuths_deg.size(); ++i) {
      std::vector<float> voice(turn);
      for (std::ptrdiff_t t = 0; t < turn; ++t) {
        const double envelope = std::pow(std::sin(static_cast<double>(t) / 900.0), 4.0);
        voice[t] = static_cast<float>(0.1 * envelope * random.normal());
      }
      const Waveform panned = pan_binaural(
          voice, head, {.azimuth_rad = radians_from_degrees(azimuths_deg[i]), .distance_m = 1.5});
      for (int ear = 0; ear < 2; ++ear) {
        std::ranges::copy(panned.channel(ear),
                          sound.channel(ear).begin() + static_cast<std::ptrdiff_t>(i) * turn);
      }
    }
    source_.sound.path = folder_ / "sound.wav";
    write_sound(source_.sound.path, sound, SampleFormat::float32);
  }

  PeopleInClip find(PeopleDetector* detector, bool hears_direction = true) {
    SilentProgress silent;
    return find_people(
        source_, survey_sound(source_.sound),
        {.detector = detector, .horizontal_fov_rad = kFov_rad, .hears_direction = hears_direction},
        silent);
  }

  fs::path folder_;
  RenderInput source_;
};

TEST_F(FindPeople, FollowsTurnsOfTwoPeopleAndOneWhoIsNotInThePicture) {
  speak_from({25.0, -20.0, 110.0});
  ToldDetector detector({{box_at(25.0), 0.9}, {box_at(-20.0), 0.8}});
  const PeopleInClip people = find(&detector);
  EXPECT_EQ(detector.looks, 1) << "a still picture is looked at once";
  ASSERT_EQ(people.frames.size(), 30U);
  const auto frame_at = [&](double time_s) {
    return people.frames[static_cast<std::size_t>(time_s * 5.0)];
  };
  EXPECT_GT(frame_at(1.0).speaking(0), 0.9);
  EXPECT_GT(frame_at(3.0).speaking(1), 0.9);
  EXPECT_GT(frame_at(5.0).belief.outside, 0.9);
  const SpeakerTrack track = speaker_track(people).value();
  EXPECT_NEAR(track.at(1.0)->x_min, box_at(25.0).x_min, 1e-9);
  EXPECT_NEAR(track.at(3.0)->x_min, box_at(-20.0).x_min, 1e-9);
  EXPECT_FALSE(track.at(5.0));
  const SpeakerSummary summary = summary_of(people);
  EXPECT_EQ(summary.people, 2);
  // Two turns of three are inside the picture; the estimate takes up to half a second to change, a
  // twelfth of the clip.
  EXPECT_NEAR(summary.outside_share, 1.0 / 3.0, 0.1);
  EXPECT_GT(summary.certainty, 0.9);
  // Rendering reads from the CSV what was found, rounded to four decimals.
  const SpeakerTrack read = SpeakerTrack::parse_csv(csv_of(people), "people.csv");
  for (double time_s = 0.1; time_s < 6.0; time_s += 0.2) {
    ASSERT_EQ(read.at(time_s).has_value(), track.at(time_s).has_value()) << time_s;
    if (!track.at(time_s)) continue;
    EXPECT_NEAR(read.at(time_s)->x_min, track.at(time_s)->x_min, 1e-4);
  }
}

TEST_F(FindPeople, WithoutBinauralSoundTakesNoSides) {
  speak_from({25.0});
  ToldDetector detector({{box_at(25.0), 0.9}, {box_at(-20.0), 0.8}});
  const PeopleInClip people = find(&detector, false);
  EXPECT_FALSE(people.hears_direction);
  EXPECT_NEAR(people.frames[5].belief.people[0], 0.45, 1e-9);
  EXPECT_NEAR(people.frames[5].belief.people[1], 0.45, 1e-9);
}

TEST_F(FindPeople, FindsNobodyWhereNobodyIsOrNothingLooks) {
  speak_from({0.0});
  ToldDetector nobody({});
  EXPECT_FALSE(speaker_track(find(&nobody)));
  EXPECT_EQ(summary_of(find(&nobody)).outside_share, 1.0);
  const PeopleInClip unseen = find(nullptr);
  EXPECT_EQ(unseen.detector, "none");
  EXPECT_FALSE(unseen.has_picture);
  source_.picture.reset();
  EXPECT_FALSE(find(&nobody).has_picture);
}

TEST_F(FindPeople, TakesGivenBoxesForTheSpeaker) {
  speak_from({-20.0});
  source_.speaker_track = SpeakerTrack(box_at(25.0));
  const PeopleInClip people = find(nullptr);
  EXPECT_EQ(people.detector, "given boxes");
  EXPECT_GT(people.frames[5].speaking(0), 0.9);
}

TEST_F(FindPeople, DrawsAMovieOfAStillPicture) {
  speak_from({25.0});
  ToldDetector detector({{box_at(25.0), 0.9}});
  const PeopleInClip people = find(&detector);
  SilentProgress silent;
  write_people_movie(folder_ / "people.mp4", source_, people, silent);
  FrameReader movie(folder_ / "people.mp4");
  EXPECT_EQ(movie.info().width, 64);
  EXPECT_NEAR(movie.duration_s(), 2.0, 0.21);  // a picture more or less
  Image drawn(640, 480, 3, 90);
  draw_people(drawn, people.frames[5]);
  const int left = static_cast<int>(box_at(25.0).x_min * 640);
  EXPECT_GT(drawn.at(left, 300, 0), drawn.at(left, 300, 2) + 50) << "an orange edge";
  EXPECT_EQ(drawn.at(600, 300, 0), 90);
}

}  // namespace
}  // namespace earpoint
