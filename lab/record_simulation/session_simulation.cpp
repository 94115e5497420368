#include <earpoint/record_simulation/session_simulation.h>

#include "camera_ring.h"
#include "session_files.h"

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include <earpoint/audio/resample.h>
#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/core/parallel.h>
#include <earpoint/error.h>
#include <earpoint/generate/work_plan.h>
#include <earpoint/media/movie_writer.h>
#include <earpoint/record_simulation/device_sound.h>
#include <earpoint/scene/homes.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// Keys of the random streams of a session: a draw from one does not shift the others.
enum StreamKey : std::uint64_t { kPlanKey = 1, kTraceKey, kClapKey, kNoiseKey, kPixelKey };

constexpr int kSpeechRate_hz = 16000;  // what read_speech gives

/// Makes one session.
class SessionMaker {
 public:
  SessionMaker(const SessionSimulationOptions& options, const PreparedScene& scene,
               const SessionPlan& plan, const SessionFiles& files, int scenario,
               ProgressSink& progress)
      : options_(options),
        scene_(scene),
        plan_(plan),
        files_(files),
        scenario_(scenario),
        progress_(progress) {}

  void make_sound() {
    const HrtfSet speech_ears = HrtfSet::load(kSpeechRate_hz);
    const HrtfSet ears = HrtfSet::load(kDeviceRate_hz);
    SessionSound speech = hear_speech(scene_, plan_, options_.sound, speech_ears,
                                      stream(kTraceKey).next(), options_.jobs, progress_);
    const double noise_power =
        mean_speech_power(speech, plan_) * std::pow(10.0, -options_.snr_db / 10.0);
    const SessionRecorder recorder(ears, noise_power);
    ThreadPool pool(options_.jobs);
    upsample(speech.cameras, pool);
    upsample(speech.microphones, pool);
    add_clap(scene_, plan_, options_.sound, ears, stream(kClapKey).next(), speech);
    create_folder(files_.sound_folder);
    const auto cameras = std::ssize(files_.movies);
    progress_.begin("recording", static_cast<double>(plan_.clocks.size()), "devices");
    pool.run(std::ssize(plan_.clocks), [&](std::ptrdiff_t task, int) {
      const auto device = static_cast<std::size_t>(task);
      RandomStream random(options_.seed,
                          {static_cast<std::uint64_t>(scenario_), kNoiseKey, device});
      const DeviceClock& clock = plan_.clocks[device];
      const double end_s = plan_.ends_s[device];
      if (task < cameras) {
        write_sound(files_.camera_sounds[device],
                    recorder.camera(speech.cameras[device], clock, end_s, random),
                    SampleFormat::float32);
      } else {
        const auto person = static_cast<std::size_t>(task - cameras);
        write_sound(files_.microphones[person],
                    recorder.microphone(speech.microphones[person], clock, end_s, random),
                    SampleFormat::pcm24);
      }
      progress_.advance(1.0);
    });
    progress_.finish();
  }

  void make_movies() {
    std::vector<MovieWriter> movies;
    for (std::size_t i = 0; i < files_.movies.size(); ++i) {
      movies.emplace_back(files_.movies[i], options_.picture.width, options_.picture.height,
                          options_.session.frame_rate_hz, kDeviceRate_hz);
    }
    std::vector<PersonBox> boxes;
    film_session(scene_, plan_, options_.session.frame_rate_hz, options_.picture,
                 stream(kPixelKey).next(), options_.jobs, progress_,
                 [&](const SessionFrame& frame) {
                   movies[frame.camera].write_picture(frame.rgb);
                   boxes.insert(boxes.end(), frame.boxes.begin(), frame.boxes.end());
                 });
    std::ranges::stable_sort(boxes, {}, &PersonBox::camera);
    write_person_boxes(files_.boxes, boxes);
    for (std::size_t i = 0; i < movies.size(); ++i) {
      copy_sound(files_.camera_sounds[i], movies[i]);
      movies[i].close();
    }
  }

 private:
  [[nodiscard]] RandomStream stream(StreamKey key) const {
    return {options_.seed, {static_cast<std::uint64_t>(scenario_), key}};
  }

  static void upsample(std::vector<Waveform>& sounds, ThreadPool& pool) {
    pool.run(std::ssize(sounds), [&](std::ptrdiff_t task, int) {
      Waveform& sound = sounds[static_cast<std::size_t>(task)];
      sound = resample(sound, kDeviceRate_hz);
    });
  }

  static void copy_sound(const fs::path& path, MovieWriter& movie) {
    SoundReader reader(path);
    constexpr std::ptrdiff_t kBlock = 1 << 16;
    while (true) {
      const Waveform block = reader.read(kBlock);
      if (block.samples() == 0) return;
      movie.write_sound(block);
    }
  }

  const SessionSimulationOptions& options_;
  const PreparedScene& scene_;
  const SessionPlan& plan_;
  const SessionFiles& files_;
  int scenario_;
  ProgressSink& progress_;
};

void simulate_session(const SessionSimulationOptions& options, int scenario, DataSplit split,
                      const PreparedScene& scene, const FigureLibrary& figures,
                      const SpeechCorpus& corpus, ProgressSink& progress) {
  RandomStream random(options.seed, {static_cast<std::uint64_t>(scenario), kPlanKey});
  const SessionPlan plan = plan_session(scene, figures, corpus, split, options.session, random);
  const SessionFiles files(session_folder(options, scenario), plan);
  if (files.has_all()) return;
  create_folder(files.folder);
  SessionMaker maker(options, scene, plan, files, scenario, progress);
  if (!files.has_sound()) maker.make_sound();
  maker.make_movies();
  write_session_truth(files.truth, truth_of(plan));
  write_session(files.session, describe_session(files, plan, options.picture,
                                                fmt::format("scenario-{:04}", scenario), split));
  std::error_code ignored;
  fs::remove_all(files.sound_folder, ignored);
}

}  // namespace

fs::path session_folder(const SessionSimulationOptions& options, int scenario) {
  if (options.scenarios == 1) return options.folder;
  return options.folder / fmt::format("scenario-{:04}", scenario);
}

std::shared_ptr<const PreparedScene> draw_flat(std::uint64_t seed, const FurnitureLibrary& library,
                                               int cameras) {
  constexpr int kHomes = 8;
  constexpr double kRoomy_m = 1.9;
  HomeOptions options;
  options.plan.rooms = 3;
  options.plan.area_m2 = 90.0;
  std::shared_ptr<const PreparedScene> best;
  double best_m = -1.0;
  for (std::uint64_t home = 0; home < kHomes && best_m < kRoomy_m; ++home) {
    const std::uint64_t home_seed = RandomStream(seed, {home}).next();
    auto scene = prepare_home(fmt::format("flat-{:016x}", home_seed),
                              make_home(home_seed, options, library).scene);
    RandomStream random(home_seed);
    const auto ring = place_cameras(*scene, cameras, random);
    const double radius_m = ring ? ring->least_radius_m : 0.0;
    if (radius_m <= best_m) continue;
    best = std::move(scene);
    best_m = radius_m;
  }
  return best;
}

std::vector<fs::path> simulate_sessions(const SessionSimulationOptions& options,
                                        const PreparedScene& scene, const FigureLibrary& figures,
                                        const SpeechCorpus& corpus, ProgressSink& progress) {
  EARPOINT_CHECK(options.jobs > 0 && options.scenarios > 0);
  begin_simulation(options, scene.name);
  std::vector<fs::path> sessions;
  const std::vector<WorkItem> items =
      plan_work({.scenes = options.scenarios, .conversations = 1, .split = {}});
  for (int scenario = 0; scenario < options.scenarios; ++scenario) {
    const DataSplit split =
        options.scenarios == 1 ? options.split : items[static_cast<std::size_t>(scenario)].voices;
    simulate_session(options, scenario, split, scene, figures, corpus, progress);
    sessions.push_back(session_folder(options, scenario) / "session.json");
  }
  return sessions;
}

}  // namespace earpoint
