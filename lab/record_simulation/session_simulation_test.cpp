#include "session_test_data.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/generate_testing/quick_generation.h>
#include <earpoint/media/media.h>
#include <earpoint/record/session.h>
#include <earpoint/record/session_truth.h>
#include <earpoint/record_simulation/session_simulation.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// Ten seconds, two cameras, few rays and pixels.
SessionSimulationOptions quick_session(const fs::path& folder) {
  SessionSimulationOptions options;
  options.folder = folder;
  options.session.people = 2;
  options.session.cameras = 2;
  options.session.duration_s = 10.0;
  options.session.frame_rate_hz = 1.0;
  options.session.walks_per_minute = 0.0;
  options.sound = {.rays = 50, .mirror_rays = 100, .response_s = 0.1};
  options.picture = {.width = 64, .height = 48, .samples_per_side = 1};
  return options;
}

class SessionSimulation : public ::testing::Test {
 protected:
  SessionSimulation()
      : folder_("session_simulation_test"),
        corpus_(SpeechCorpus::load(write_test_corpus(folder_.path() / "speech"))),
        room_(test_room(0.5)) {}

  std::vector<fs::path> simulate(const SessionSimulationOptions& options) {
    SilentProgress silent;
    return simulate_sessions(options, *room_, figures_, corpus_, silent);
  }

  TestFolder folder_;
  SpeechCorpus corpus_;
  FigureLibrary figures_;
  std::shared_ptr<const PreparedScene> room_;
};

TEST_F(SessionSimulation, WritesWhatAReaderOfSessionsTakesAndGoesOnWhereItStopped) {
  const SessionSimulationOptions options = quick_session(folder_.path() / "session");
  const std::vector<fs::path> sessions = simulate(options);
  ASSERT_EQ(sessions.size(), 1U);
  const Session session = read_session(sessions[0]);
  const SessionTruth truth = read_session_truth(options.folder / "truth.json");
  ASSERT_EQ(session.cameras.size(), 2U);
  ASSERT_EQ(session.people.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const MediaInfo info = probe_media(session.cameras[i].video);
    const StreamInfo* sound = info.preferred(StreamKind::audio);
    ASSERT_NE(sound, nullptr);
    EXPECT_EQ(sound->sample_rate_hz, 48000);
    EXPECT_EQ(sound->channels, 2);
    EXPECT_EQ(info.preferred(StreamKind::video)->width, 64);
    const double length_s = AudioReader(session.cameras[i].video).duration_s().value();
    EXPECT_GT(length_s, 10.0 - 2.0 - 0.5 - 0.1);
    EXPECT_LE(length_s, 10.0);
    const SoundInfo near = probe_sound(session.people[i].near);
    EXPECT_EQ(near.sample_rate_hz, 48000);
    EXPECT_EQ(near.channels, 1);
    EXPECT_FALSE(truth.people[i].speech.empty());
    // The drawn distance, not the default of sessions without one.
    EXPECT_GE(session.people[i].near_distance_m, 0.10);
    EXPECT_LT(session.people[i].near_distance_m, 0.20);
  }
  EXPECT_EQ(session.boxes, options.folder / "boxes.csv");
  EXPECT_EQ(session.split, "train");
  EXPECT_NEAR(*session.clap_s, device_time_s(truth.cameras[0], 3.0), 1e-9);
  EXPECT_FALSE(read_person_boxes(options.folder / "boxes.csv").empty());
  EXPECT_FALSE(fs::exists(options.folder / "sound-without-pictures"));

  // Existing files are kept; missing ones are made again with the same bytes.
  const auto before = contents_of(options.folder);
  const auto written = fs::last_write_time(options.folder / "camera-1.mp4");
  simulate(options);
  EXPECT_EQ(fs::last_write_time(options.folder / "camera-1.mp4"), written);
  fs::remove(options.folder / "near-2.wav");
  SessionSimulationOptions more_jobs = options;
  more_jobs.jobs = 2;
  simulate(more_jobs);
  EXPECT_EQ(contents_of(options.folder), before);
}

TEST_F(SessionSimulation, NoiseLiesAtTheWantedLevelBelowTheSpeech) {
  // The same session with and without noise.
  const auto near = [&](double snr_db, const char* name) {
    SessionSimulationOptions options = quick_session(folder_.path() / name);
    options.session.most_drift_ppm = 0.0;
    options.snr_db = snr_db;
    simulate(options);
    return AudioReader(options.folder / "camera-1.mp4").read(8 * 48000);
  };
  const Waveform quiet = near(80.0, "quiet");
  const Waveform noisy = near(5.0, "noisy");
  const SessionTruth truth = read_session_truth(folder_.path() / "noisy" / "truth.json");
  double speech = 0.0;
  double noise = 0.0;
  int speaking = 0;
  for (std::ptrdiff_t i = 0; i < noisy.samples(); ++i) {
    const double time_s = session_time_s(truth.cameras[0], static_cast<double>(i) / 48000.0);
    // The clap and its decay are left out.
    if (time_s < 3.5) continue;
    bool speaks = false;
    for (const PersonTruth& person : truth.people) {
      for (const SpeechInterval& interval : person.speech) {
        speaks = speaks || (time_s >= interval.begin_s && time_s < interval.end_s);
      }
    }
    if (!speaks) continue;
    ++speaking;
    for (int ear = 0; ear < 2; ++ear) {
      const double kept = quiet.channel(ear)[i];
      const double added = noisy.channel(ear)[i] - kept;
      speech += kept * kept;
      noise += added * added;
    }
  }
  ASSERT_GT(speaking, 48000);
  // The SNR holds for all cameras together. Either of the two is within some 2 dB of their mean;
  // AAC adds noise 20 dB lower.
  EXPECT_NEAR(10.0 * std::log10(speech / noise), 5.0, 2.5);
}

TEST_F(SessionSimulation, RefusesToGoOnWithOtherOptions) {
  SessionSimulationOptions options = quick_session(folder_.path() / "session");
  fs::create_directories(options.folder);
  options.scenarios = 2;
  // Fails after the folder was started: no split of the corpus has four voices.
  options.session.people = 4;
  EXPECT_THROW(simulate(options), InputError);
  options.seed = 2;
  try {
    simulate(options);
    FAIL() << "went on";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("seed is 1 there, 2 here"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace earpoint
