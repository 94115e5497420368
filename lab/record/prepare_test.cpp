#include "seen_people.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/progress.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/replay_pair.h>
#include <earpoint/error.h>
#include <earpoint/record/prepare.h>
#include <earpoint/record_testing/test_session.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// A box round a person's mouth in every camera, five times a second.
std::vector<PersonBox> boxes_of(const TestSession& made) {
  std::vector<PersonBox> boxes;
  for (std::size_t c = 0; c < made.session.cameras.size(); ++c) {
    const SessionCamera& camera = made.session.cameras[c];
    for (std::size_t p = 0; p < made.truth.people.size(); ++p) {
      for (std::size_t i = 0; i < made.truth.people[p].track.size(); i += 2) {
        const TrackPoint& point = made.truth.people[p].track[i];
        const auto at = project(point.mouth_m, *camera.lens, *camera.world_from_camera);
        if (!at) continue;
        boxes.push_back({.camera = static_cast<int>(c),
                         .frame = static_cast<int>(i / 2),
                         .time_s = device_time_s(made.truth.cameras[c], point.time_s),
                         .person = static_cast<int>(p),
                         .box = {.x_min = std::max(0.0, at->x - 0.08),
                                 .y_min = std::max(0.0, at->y - 0.1),
                                 .x_max = std::min(1.0, at->x + 0.08),
                                 .y_max = std::min(1.0, at->y + 0.4)},
                         .visible = 1.0});
      }
    }
  }
  return boxes;
}

TEST(SeenPeople, BoxesOfOnePictureASecondServeTheTimeBetween) {
  const fs::path path =
      fs::path(testing::TempDir()) / ("seen_people." + std::to_string(::getpid()) + ".csv");
  std::vector<PersonBox> boxes;
  for (int frame = 0; frame < 5; ++frame) {
    PersonBox& box = boxes.emplace_back();
    box.frame = frame;
    box.time_s = frame;
  }
  write_person_boxes(path, boxes);
  Session session;
  session.cameras.resize(1);
  session.cameras[0].name = "1";
  session.people.resize(1);
  session.boxes = path;
  SyncResult sync;
  sync.devices.emplace_back().clock.name = "1";
  const SeenPeople people(session, sync);
  ASSERT_NE(people.seen_box(0, 0, 2.45), nullptr);
  EXPECT_EQ(people.seen_box(0, 0, 2.45)->frame, 2);
  EXPECT_EQ(people.seen_box(0, 0, 4.6), nullptr);
  fs::remove(path);
}

/// One session of four cameras and two people, recorded once for all tests.
class Prepare : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    root() = fs::path(testing::TempDir()) / ("prepare_test." + std::to_string(::getpid()));
    fs::remove_all(root());
    made() =
        make_test_session({.cameras = 4, .people = 2, .duration_s = 24.0, .reverberation_s = 0.0});
    write_person_boxes((fs::create_directories(root() / "in"), root() / "in" / "boxes.csv"),
                       boxes_of(made()));
    made().session.boxes = root() / "in" / "boxes.csv";
    write_test_session(root() / "in", made());
    SilentProgress silent;
    summary() = prepare_session(read_session(root() / "in" / "session.json"),
                                {.out = root() / "out", .split = "test"}, silent);
  }
  static void TearDownTestSuite() { fs::remove_all(root()); }

  static PrepareSummary prepare(const fs::path& session, const fs::path& out) {
    SilentProgress silent;
    return prepare_session(read_session(session), {.out = out, .split = "test"}, silent);
  }

  static fs::path& root() {
    static fs::path path;
    return path;
  }
  static TestSession& made() {
    static TestSession session;
    return session;
  }
  static PrepareSummary& summary() {
    static PrepareSummary first;
    return first;
  }
};

TEST_F(Prepare, OurReaderReadsClipsAndTheirTruePoses) {
  EXPECT_TRUE(summary().notes.empty()) << summary().notes.front();
  const ReplayDataset dataset(replay_options(root() / "out", "test"));
  ASSERT_EQ(dataset.clips().size(), static_cast<std::size_t>(summary().clips));
  EXPECT_GT(summary().silent, 3);
  EXPECT_GT(summary().clips, 20);
  const ReplayClip& clip = dataset.clips()[5];
  ASSERT_EQ(clip.images.size(), 4U);
  const PairSample sample = replay_pair(dataset, clip, {0, 2}, false);
  EXPECT_EQ(sample.source.samples(), 16000);
  // Cameras look at one point and are level: the camera file keeps their orientation completely.
  const Pose expected = inverse(*made().session.cameras[0].world_from_camera) *
                        *made().session.cameras[2].world_from_camera;
  EXPECT_LT(norm(sample.source_from_target.position_m - expected.position_m), 1e-6);
  const Vector3 front{1, 0, 0};
  EXPECT_LT(norm(rotate(sample.source_from_target.orientation, front) -
                 rotate(expected.orientation, front)),
            1e-6);
  ASSERT_TRUE(sample.speaker_box);
  // Four cameras locate heights badly; horizontally a voice is found to within a step.
  const Vector3 mouth = *clip.mouth_m;
  double nearest_m = 10.0;
  for (const PersonTruth& person : made().truth.people) {
    for (const TrackPoint& point : person.track) {
      nearest_m =
          std::min(nearest_m, std::hypot(point.mouth_m.x - mouth.x, point.mouth_m.y - mouth.y));
    }
  }
  EXPECT_LT(nearest_m, 0.5);
}

TEST_F(Prepare, BoxesAreInTheSpeakersDirectionByTheFieldOfView) {
  const ReplayDataset dataset(replay_options(root() / "out", "test"));
  const ReplaySampler sampler(dataset, 0);
  std::vector<double> errors_rad;
  for (const ReplayClip& clip : dataset.clips()) {
    for (int view = 0; view < 4; ++view) {
      const PairSample sample = sampler.sample(clip, {view, (view + 1) % 4}, false);
      const Lens& lens = *made().session.cameras[static_cast<std::size_t>(view)].lens;
      const double half_width = 0.5 * lens.width_px / lens.fx_px;
      ASSERT_NEAR(std::tan(0.5 * sample.horizontal_fov_rad), half_width, 1e-9);
      if (!sample.speaker_box || sample.speaker_box->x_min < 0.01 ||
          sample.speaker_box->x_max > 0.99) {
        continue;
      }
      const double middle = 0.5 * (sample.speaker_box->x_min + sample.speaker_box->x_max);
      const double seen_rad = std::atan((1.0 - 2.0 * middle) * half_width);
      const double true_rad = std::atan2(sample.speaker_m.y, sample.speaker_m.x);
      errors_rad.push_back(std::abs(wrap_angle(seen_rad - true_rad)));
    }
  }
  ASSERT_GT(errors_rad.size(), 40U);
  std::ranges::nth_element(errors_rad, errors_rad.begin() + std::ssize(errors_rad) / 2);
  // A voice is found to within some ten centimetres in two metres or more.
  EXPECT_LT(degrees_from_radians(errors_rad[errors_rad.size() / 2]), 4.0);
}

TEST_F(Prepare, AClipHearsTheSameMomentInAllCamerasAndTheNearMicrophone) {
  const ReplayDataset dataset(replay_options(root() / "out", "test"));
  // Offsets between devices are seconds; after alignment up to 20 ms of travel time are left.
  // Envelopes of 20 ms agree then, and hardly by chance.
  int agree = 0;
  for (const ReplayClip& clip : dataset.clips()) {
    const fs::path folder = root() / "out" / clip.folder;
    const Waveform near = read_sound(folder / "near.wav");
    const Waveform far = read_sound(folder / "3.wav");
    std::vector<double> a;
    std::vector<double> b;
    for (std::ptrdiff_t i = 0; i + 320 <= near.samples(); i += 320) {
      double x = 0.0;
      double y = 0.0;
      for (std::ptrdiff_t n = i; n < i + 320; ++n) {
        x += std::abs(near.channel(0)[n]);
        y += std::abs(far.channel(0)[n]);
      }
      a.push_back(x);
      b.push_back(y);
    }
    double ab = 0.0;
    double aa = 0.0;
    double bb = 0.0;
    const double mean_a = std::accumulate(a.begin(), a.end(), 0.0) / static_cast<double>(a.size());
    const double mean_b = std::accumulate(b.begin(), b.end(), 0.0) / static_cast<double>(b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      ab += (a[i] - mean_a) * (b[i] - mean_b);
      aa += (a[i] - mean_a) * (a[i] - mean_a);
      bb += (b[i] - mean_b) * (b[i] - mean_b);
    }
    if (ab > 0.6 * std::sqrt(aa * bb)) ++agree;
  }
  EXPECT_GE(agree, 9 * static_cast<int>(dataset.clips().size()) / 10);
}

TEST_F(Prepare, GoesOnWhereItWasStopped) {
  EXPECT_EQ(prepare(root() / "in" / "session.json", root() / "out").made, 0);
  const ReplayDataset dataset(replay_options(root() / "out", "test"));
  fs::remove(root() / "out" / dataset.clips()[3].folder / "2.wav");
  fs::remove_all(root() / "out" / dataset.clips()[7].folder);
  EXPECT_EQ(prepare(root() / "in" / "session.json", root() / "out").made, 2);
  EXPECT_TRUE(fs::exists(root() / "out" / dataset.clips()[3].folder / "2.wav"));
}

TEST_F(Prepare, SwappedMicrophonesAreFoundByWhereVoicesComeFrom) {
  const fs::path session = root() / "in" / "swapped.json";
  Session swapped = made().session;
  std::swap(swapped.people[0].near, swapped.people[1].near);
  write_session(session, swapped);
  const PrepareSummary found = prepare(session, root() / "swapped");
  ASSERT_EQ(found.notes.size(), 2U);
  EXPECT_NE(found.notes[0].find("swapped"), std::string::npos) << found.notes[0];
}

TEST_F(Prepare, WhoWearsWhichMicrophoneIsFoundWhereTheSessionDoesNotSayIt) {
  const fs::path session = root() / "in" / "open.json";
  Session open = made().session;
  std::swap(open.people[0].near, open.people[1].near);
  open.wearers_known = false;
  write_session(session, open);
  const PrepareSummary found = prepare(session, root() / "open");
  ASSERT_EQ(found.notes.size(), 2U);
  EXPECT_EQ(found.notes[0].find("person-2.wav is worn by person-2, "), 0U) << found.notes[0];
  EXPECT_EQ(found.notes[1].find("person-1.wav is worn by person-1, "), 0U) << found.notes[1];
}

TEST_F(Prepare, WhatIsWrongWithADeviceIsALineAndTheOthersAreKept) {
  Session session = made().session;
  session.cameras[1].world_from_camera.reset();
  session.cameras[1].lens.reset();
  session.cameras.push_back({.name = "9",
                             .video = root() / "in" / "nowhere.mp4",
                             .lens = {},
                             .world_from_camera = session.cameras[3].world_from_camera});
  // Half of a movie: what can be read is used.
  const std::vector<std::byte> whole = read_file(session.cameras[3].video);
  std::ofstream(root() / "in" / "cut.mp4", std::ios::binary)
      .write(reinterpret_cast<const char*>(whole.data()),
             static_cast<std::streamsize>(whole.size() / 2));
  session.cameras.push_back({.name = "10",
                             .video = root() / "in" / "cut.mp4",
                             .lens = {},
                             .world_from_camera = session.cameras[3].world_from_camera});
  session.boxes.reset();
  const fs::path path = root() / "in" / "troubled.json";
  write_session(path, session);
  const PrepareSummary found = prepare(path, root() / "troubled");
  EXPECT_EQ(found.cameras, 4);
  EXPECT_GT(found.clips, 20);
  const auto told = [&](const std::string& text) {
    return std::ranges::any_of(found.notes, [&](const std::string& note) {
      return note.find(text) != std::string::npos && note.find('\n') == std::string::npos;
    });
  };
  EXPECT_TRUE(told("camera 2 is left out: it is not calibrated"));
  EXPECT_TRUE(told("camera 9 is left out: "));
  EXPECT_TRUE(told("camera 10: "));
}

}  // namespace
}  // namespace earpoint
