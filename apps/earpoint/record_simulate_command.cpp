#include "arguments.h"
#include "flag_checks.h"
#include "record_command.h"
#include "scene_argument.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <earpoint/core/parallel.h>
#include <earpoint/core/progress.h>
#include <earpoint/error.h>
#include <earpoint/record_simulation/session_simulation.h>
#include <earpoint/scene/model_pack.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

struct Options {
  SessionSimulationOptions simulation;
  SceneArgument scene;
  std::optional<fs::path> speech;
  std::string split = "train";
  std::string size = "480x270";
  double minutes = 3.0;
  double fov_degrees = 80.0;
  int people = 0;
  int samples = 4;
  int jobs = 0;
  bool quiet = false;
};

int parse_side(std::string_view text, const std::string& whole) {
  int side = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), side);
  if (error != std::errc() || end != text.data() + text.size() || side < 32 || side > 4096) {
    throw InputError("--size",
                     "expected WIDTHxHEIGHT with 32 to 4096 pixels, found '" + whole + "'");
  }
  return side;
}

void take_size(const std::string& text, SessionPictureQuality& picture) {
  const std::size_t cross = text.find('x');
  const std::string_view view = text;
  picture.width = parse_side(view.substr(0, cross), text);
  picture.height = parse_side(cross == std::string::npos ? "" : view.substr(cross + 1), text);
}

bool names_a_scene(const SceneArgument& scene) {
  return !scene.file.empty() || !scene.shoebox.empty() || scene.home_seed;
}

std::shared_ptr<const PreparedScene> prepare(const Options& options, ModelPack& models) {
  if (!names_a_scene(options.scene)) {
    return draw_flat(options.simulation.seed, FurnitureLibrary(std::move(models.furniture)),
                     options.simulation.session.cameras);
  }
  NamedScene named = read_scene(options.scene);
  for (const std::string& warning : named.warnings) {
    fmt::print(stderr, "earpoint: {}\n", warning);
  }
  const std::string name = !options.scene.file.empty() ? options.scene.file.stem().string()
                           : options.scene.home_seed
                               ? fmt::format("home-{}", *options.scene.home_seed)
                               : "shoebox-" + options.scene.shoebox;
  return prepare_scan(name, std::move(named.scene));
}

void run(Options options) {
  SessionSimulationOptions& simulation = options.simulation;
  take_size(options.size, simulation.picture);
  simulation.picture.horizontal_fov_rad = radians_from_degrees(options.fov_degrees);
  simulation.picture.samples_per_side = static_cast<int>(std::lround(std::sqrt(options.samples)));
  simulation.session.duration_s = 60.0 * options.minutes;
  if (options.people > 0) simulation.session.people = options.people;
  simulation.split = *data_split_named(options.split);
  simulation.jobs = options.jobs > 0 ? options.jobs : available_cores();

  const SpeechCorpus corpus = SpeechCorpus::load(options.speech.value_or(default_speech_folder()));
  ModelPack models = installed_models();
  const std::string lack = warning_of(models);
  if (!options.quiet && !names_a_scene(options.scene) && !lack.empty()) {
    fmt::print(stderr, "earpoint: {}\n", lack);
  }
  const auto scene = prepare(options, models);
  const FigureLibrary figures(std::move(models.figures));
  StreamProgress bar(stderr);
  SilentProgress silent;
  ProgressSink& progress = options.quiet ? static_cast<ProgressSink&>(silent) : bar;
  const std::vector<fs::path> sessions =
      simulate_sessions(simulation, *scene, figures, corpus, progress);
  if (options.quiet) return;
  for (const fs::path& session : sessions) fmt::print("{}\n", session.string());
}

void add_what(CLI::App& command, Options& options) {
  SessionOptions& session = options.simulation.session;
  command
      .add_option("--minutes", options.minutes,
                  "Length of a session; its sound is held in memory, "
                  "about 150 MB a minute")
      ->check(within(0.25, 30.0))
      ->capture_default_str();
  command
      .add_option("--people", options.people,
                  "Number of people, 2 to 4; 0: random for each session")
      ->check(CLI::IsMember({0, 2, 3, 4}))
      ->capture_default_str();
  command
      .add_option("--cameras", session.cameras, "Number of cameras, in a ring around the people")
      ->check(within(1, 32))
      ->capture_default_str();
  command.add_option("--walks", session.walks_per_minute, "Walks to another place per minute")
      ->check(within(0, 20))
      ->capture_default_str();
  command
      .add_option(
          "--scenarios", options.simulation.scenarios,
          "Number of sessions, each in its own folder; three or more are split 90 : 10 : 20 "
          "into train, val and test")
      ->check(within(1, 10000))
      ->capture_default_str();
  command
      .add_option("--split", options.split,
                  "Split of the voices and figures of a single session: train, val or test")
      ->check(CLI::IsMember({"train", "val", "test"}))
      ->capture_default_str();
  command
      .add_option("--seed", options.simulation.seed,
                  "The same seed gives the same sessions, in the same flat")
      ->check(whole_number())
      ->capture_default_str();
  command.add_option("--speech", options.speech,
                     "Folder of recorded voices (speech.csv, or LibriSpeech); default: that of "
                     "./dev speech");
}

void add_devices(CLI::App& command, Options& options) {
  SessionSimulationOptions& simulation = options.simulation;
  command
      .add_option("--snr", simulation.snr_db,
                  "Level of the speech at the cameras over the ambient noise, dB")
      ->check(within(-20, 100))
      ->capture_default_str();
  command
      .add_option("--drift", simulation.session.most_drift_ppm,
                  "Largest drift of a clock in either direction, parts per million")
      ->check(within(0, 1000))
      ->capture_default_str();
  command
      .add_option("--offset", simulation.session.most_offset_s,
                  "Largest time between the starts of two recordings, seconds")
      ->check(within(0, 5))
      ->capture_default_str();
  command.add_option("--size", options.size, "Size of the pictures, WIDTHxHEIGHT in pixels")
      ->capture_default_str();
  command.add_option("--fps", simulation.session.frame_rate_hz, "Pictures per second")
      ->check(within(1, 30))
      ->capture_default_str();
  command.add_option("--fov", options.fov_degrees, "Horizontal field of view, degrees")
      ->check(within(20, 130))
      ->capture_default_str();
  command
      .add_option("--samples", options.samples,
                  "Rays per pixel, a square number; 1 takes a third of the time")
      ->check(CLI::IsMember({1, 4, 9, 16}))
      ->capture_default_str();
  command.add_option("--rays", simulation.sound.rays, "Rays from each mouth")
      ->check(within(1, 1e6))
      ->capture_default_str();
}

}  // namespace

void add_record_simulate_command(CLI::App& record) {
  auto options = std::make_shared<Options>();
  CLI::App* command = record.add_subcommand(
      "simulate", "Simulate a session of a conversation between cameras, with known truth.");
  command
      ->add_option("--out", options->simulation.folder,
                   "Output folder; an interrupted run continues there")
      ->required();
  add_what(*command, *options);
  add_scene_argument(*command, options->scene);
  add_devices(*command, *options);
  command->add_option("--jobs", options->jobs, "Threads; 0 takes all cores")->capture_default_str();
  command->add_flag("--quiet", options->quiet, "Print nothing but errors");
  command->footer(R"(
Examples:
  earpoint record simulate --out session --seed 1 --minutes 3
  earpoint record simulate --out session --people 2 --snr 10 --home 7 --size 640x360
  earpoint record simulate --out sessions --scenarios 12 --minutes 2

Two to four people sit, stand and walk in a furnished flat and talk in turns and over each other. A
ring of cameras records them with binaural sound, and everybody wears a microphone near the mouth; every
device has its own clock. Without a scene, the flat is generated from the seed. The output is session.json,
camera-N.mp4, near-N.wav, and the truth: truth.json and boxes.csv (docs/formats.md). An interrupted run
continues when it is started again.
)");
  command->callback([options] { run(*options); });
}

}  // namespace earpoint
