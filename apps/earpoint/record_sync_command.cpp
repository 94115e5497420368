#include "record_command.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/core/progress.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>
#include <earpoint/record/session.h>
#include <earpoint/record/session_sync.h>
#include <earpoint/record/session_truth.h>
#include <earpoint/record/sync.h>
#include <earpoint/record/sync_file.h>
#include <earpoint/record/sync_plot.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFooter = R"(
Examples:
  earpoint record sync session.json
  earpoint record sync session.json -o sync.json --plot sync.png
  earpoint record sync session.json --truth truth.json --json     # of a simulated session

Session time is the first camera's clock. What a device recorded at its own time c happened at
offset_s + c / (1 + 1e-6 drift_ppm). Clocks are estimated by
  positions  arrival times of voices at calibrated cameras, corrected for the travel time of sound
  onsets     onset times of sounds, to about ten milliseconds, where the camera's position is unknown
The session file is described in docs/formats.md.
)";

struct Options {
  fs::path session;
  std::optional<fs::path> truth;
  std::optional<fs::path> output;
  std::optional<fs::path> plot;
  bool json = false;
  bool quiet = false;
};

void print_table(const SyncResult& result, const SyncErrors* errors) {
  fmt::print("{:<20}{:>14}{:>12}{:>10}{:>9}  {}\n", "device", "offset_s", "drift_ppm", "clap_s",
             "windows", "method");
  for (const SyncedDevice& device : result.devices) {
    const std::string clap = device.clap_s ? fmt::format("{:.3f}", *device.clap_s) : "-";
    const std::string name = (device.is_camera ? "camera " : "near ") + device.clock.name;
    fmt::print("{:<20}{:>14.6f}{:>12.2f}{:>10}{:>9}  {}\n", name, device.clock.offset_s,
               device.clock.drift_ppm, clap, device.windows, name_of(device.method));
  }
  if (errors == nullptr) return;
  fmt::print("offset error {:.3f} ms, drift error {:.3f} ppm at the 95th percentile\n",
             errors->offset_error_ms_p95, errors->drift_error_ppm_p95);
}

void run(const Options& options) {
  if (options.plot) check_image_path(*options.plot);
  const Session session = read_session(options.session);
  std::optional<SessionTruth> truth;
  if (options.truth) truth = read_session_truth(*options.truth);
  SilentProgress silent;
  StreamProgress bar(stderr);
  ProgressSink& progress = options.quiet ? static_cast<ProgressSink&>(silent) : bar;
  const DeviceSounds sounds = read_device_sounds(session, progress);
  const SyncResult result = synchronize_session(session, sounds, progress);
  for (const std::string& note : result.notes) fmt::print(stderr, "earpoint: {}\n", note);

  std::optional<SyncErrors> errors;
  if (truth) {
    errors = compare_clocks(result, *truth, sounds.devices.front().sound.duration_s());
  }
  const SyncErrors* told = errors ? &*errors : nullptr;
  if (options.plot) {
    write_image(*options.plot, plot_sync(result, sounds.devices.front().sound.duration_s()));
  }
  if (options.output) write_file(*options.output, std::string_view(json_of(result)));
  if (options.json) {
    fmt::print("{}", json_of(result, told));
  } else {
    print_table(result, told);
  }
}

}  // namespace

void add_record_sync_command(CLI::App& record) {
  auto options = std::make_shared<Options>();
  CLI::App* command = record.add_subcommand(
      "sync", "Estimate the clock offset and drift of every device of a session.");
  command->add_option("session", options->session, "session.json")->required();
  command->add_option("--truth", options->truth,
                      "truth.json of a simulated session, to print the errors of the clocks");
  command->add_option("-o,--output", options->output, "Write the clocks as JSON");
  command->add_option("--plot", options->plot,
                      "Picture (.png, .jpg) of the residuals of the arrival times, by device");
  command->add_flag("--json", options->json, "Print JSON");
  command->add_flag("--quiet", options->quiet, "No progress");
  command->footer(kFooter);
  command->callback([options] { run(*options); });
}

}  // namespace earpoint
