#include "record_command.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>

#include <earpoint/core/progress.h>
#include <earpoint/error.h>
#include <earpoint/record/prepare.h>
#include <earpoint/record/session.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFooter = R"(
Examples:
  earpoint record prepare monday/session.json --out data/recorded --split train
  earpoint record prepare tuesday/session.json --out data/recorded --split test
  earpoint evaluate --data data/recorded --layout replay --methods input,dsp,gtf

Every session is a scene of the data set, all of it in one split. Devices are synchronised first, as by
`earpoint record sync`. Seconds in which nobody speaks, and knocks, are left out by the energy of the near
microphones; those in which two people speak are marked. An interrupted run continues when it is started
again. The folders are described in docs/formats.md.
)";

struct Options {
  fs::path session;
  PrepareOptions prepare;
  std::string split;
  bool quiet = false;
};

void run(const Options& options) {
  const Session session = read_session(options.session);
  PrepareOptions prepare = options.prepare;
  if (!options.split.empty()) prepare.split = options.split;
  SilentProgress silent;
  StreamProgress bar(stderr);
  ProgressSink& progress = options.quiet ? static_cast<ProgressSink&>(silent) : bar;
  const PrepareSummary made = prepare_session(session, prepare, progress);
  for (const std::string& note : made.notes) fmt::print(stderr, "earpoint: {}\n", note);
  fmt::print("{}: {} clips of {} cameras in split {} ({} made now, {} with two people speaking)\n",
             made.scene, made.clips, made.cameras, made.split, made.made, made.overlapping);
  fmt::print("of {} windows, {} were silent and {} noisy\n", made.windows, made.silent, made.noisy);
}

}  // namespace

void add_record_prepare_command(CLI::App& record) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      record.add_subcommand("prepare", "Cut a session into clips, in the layout of Replay-NVAS.");
  command->add_option("session", options->session, "session.json")->required();
  command->add_option("--out", options->prepare.out, "Folder of the data set")->required();
  command
      ->add_option(
          "--split", options->split,
          "Split of the scene (default: the session's; else that of the published scene of "
          "that name; else train)")
      ->check(CLI::IsMember({"train", "val", "test"}));
  command->add_option("--hop", options->prepare.hop_s, "Seconds between the beginnings of windows")
      ->check(CLI::Range(0.05, 60.0))
      ->capture_default_str();
  command->add_flag("--quiet", options->quiet, "No progress");
  command->footer(kFooter);
  command->callback([options] { run(*options); });
}

}  // namespace earpoint
