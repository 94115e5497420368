#include "study_command.h"

#include "page_options.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/serve/page_server.h>
#include <earpoint/study/simulated_participant.h>
#include <earpoint/study/study_desk.h>
#include <earpoint/study/study_report.h>
#include <earpoint/study/study_server.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFooter = R"(
Examples:
  # 20 clips, four methods: which sounds closest to the true sound at the target?
  earpoint study make --data data/homes --methods input,dsp,vigas,gtf --count 20 --seed 1 -o study
  earpoint study simulate study --rule mag          # try it without people
  earpoint study serve study --port 8080            # participants use this computer
  earpoint study report study -o report             # at any time, also while it is served)";

constexpr const char* kServeFooter = R"(
Participants open the page on this computer, one after the other or in several tabs; with --host also on
others, by the printed address with its token. The code that the page asks for is optional;
?participant=CODE in the address (&participant=CODE after a token) fills it in, and each code can take part
once. Every answer is stored in answers.sqlite in the study's folder before the page continues; nothing is
lost if the page is closed or the server killed, and the page continues where it was. Stop with Ctrl-C.

Examples:
  earpoint study serve study --port 8080
  earpoint study serve study --host 0.0.0.0 --port 8080      # for several computers)";

constexpr const char* kSimulateFooter = R"(
Simulated participants open the study as a browser does, pass the headphone check and answer by
a rule: the smallest Mag against the reference, the smallest difference of level, or at random. They are
marked as simulated in answers.sqlite, in tables, CSV, JSON and on the report's page, and are not counted as
people.

Examples:
  earpoint study simulate study --rule mag
  earpoint study simulate study --rule random --count 10 --seed 5)";

constexpr const char* kReportFooter = R"(
Shares (or mean ratings) have 95 % intervals, bootstrapped over participants and clips. Each method is
tested against each baseline by sign tests: over answers, as if they were independent, over participants and
over clips; each with the smallest preference that it detects with a power of 80 %.
Participants are not counted if they failed the headphone check, did not finish, missed the reference in more
than 15 % of the controls (choice), or, after ITU-R BS.1534, rated the hidden reference below 90 on more than
15 % of the pages or an anchor's position above 90 on more than 15 % of its pages (mushra). Numbers before this
screening are printed too.

Examples:
  earpoint study report study
  earpoint study report study --json
  earpoint study report study -o report      # index.html, answers.csv, results.json)";

struct ServeArguments {
  fs::path folder;
  PageAddress address;
};

void run_serve(const ServeArguments& arguments) {
  if (!has_study_page()) {
    throw InputError("study serve", "this build has no page",
                     "install esbuild and build again (./dev build does both)");
  }
  const PageAddress address = with_token(arguments.address);
  StudyServer server(arguments.folder, address);
  serve_page(server, address, "The study is at");
}

struct SimulateArguments {
  fs::path folder;
  std::string rule = "mag";
  int count = 1;
  std::uint64_t seed = 1;
};

/// A server in a thread of its own.
class RunningServer {
 public:
  explicit RunningServer(const fs::path& folder) : server_(folder), port_(server_.bind()) {
    thread_ = std::thread([this] { server_.run(); });
  }
  ~RunningServer() {
    server_.stop();
    thread_.join();
  }
  RunningServer(const RunningServer&) = delete;
  RunningServer& operator=(const RunningServer&) = delete;

  [[nodiscard]] int port() const { return port_; }

 private:
  StudyServer server_;
  int port_;
  std::thread thread_;
};

void run_simulate(const SimulateArguments& arguments) {
  const SimulatedRule rule = simulated_rule_named(arguments.rule);
  const RunningServer server(arguments.folder);
  for (int i = 0; i < arguments.count; ++i) {
    const SimulatedOutcome outcome =
        take_part(server.port(), {.rule = rule, .seed = arguments.seed + i, .label = {}});
    fmt::print("simulated participant {} of {}, by {}: {} answers\n", i + 1, arguments.count,
               arguments.rule, outcome.answers);
  }
}

struct ReportArguments {
  fs::path folder;
  std::optional<fs::path> output;
  bool json = false;
};

void run_report(const ReportArguments& arguments) {
  const Study study = read_study(arguments.folder);
  const AnswerStore store = AnswerStore::open_to_read(
      arguments.folder / kAnswersFile, read_text_file(arguments.folder / "study.json"));
  const std::vector<StudyGroup> groups = study_results(study, store);
  if (arguments.output) write_study_report(*arguments.output, study, groups);
  fmt::print("{}", arguments.json ? json_of(study, groups) : text_of(study, groups));
}

void add_folder(CLI::App& command, fs::path& folder) {
  command.add_option("study", folder, "Folder that `earpoint study make` wrote")->required();
}

}  // namespace

void add_study_command(CLI::App& app) {
  CLI::App* study = app.add_subcommand(
      "study", "Listening studies: people compare methods with the true sound at the target.");
  study->require_subcommand(1);
  study->footer(kFooter);
  add_study_make_command(*study);
  add_study_serve_command(*study);
  add_study_simulate_command(*study);
  add_study_report_command(*study);
}

void add_study_serve_command(CLI::App& study) {
  auto arguments = std::make_shared<ServeArguments>();
  CLI::App* command = study.add_subcommand("serve", "Serve a study's page and store the answers.");
  add_folder(*command, arguments->folder);
  add_page_options(*command, arguments->address);
  command->footer(kServeFooter);
  command->callback([arguments] { run_serve(*arguments); });
}

void add_study_simulate_command(CLI::App& study) {
  auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* command =
      study.add_subcommand("simulate", "Run simulated participants through a study.");
  add_folder(*command, arguments->folder);
  command->add_option("--rule", arguments->rule, "Rule of the answers: mag, level or random")
      ->check(CLI::IsMember({"mag", "level", "random"}))
      ->capture_default_str();
  command->add_option("--count", arguments->count, "Number of participants")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--seed", arguments->seed, "Seed of the rule random")->capture_default_str();
  command->footer(kSimulateFooter);
  command->callback([arguments] { run_simulate(*arguments); });
}

void add_study_report_command(CLI::App& study) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* command = study.add_subcommand("report", "Report the results of a study.");
  add_folder(*command, arguments->folder);
  command->add_option(
      "-o,--output", arguments->output,
      "Folder for a page with the table, the answers as CSV and the results as JSON");
  command->add_flag("--json", arguments->json, "Print the results as JSON");
  command->footer(kReportFooter);
  command->callback([arguments] { run_report(*arguments); });
}

}  // namespace earpoint
