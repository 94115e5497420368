#include "pairs_command.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/dataset/dataset_folder.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFooter = R"(
Examples:
  earpoint pairs --data nvas --split test                        # writes nvas/pairs-test.json
  earpoint pairs --data nvas --split test --draw released -o pairs-released.json
  earpoint evaluate --data nvas --pairs pairs-released.json

Draws:
  every-target  every viewpoint of every clip is the target once, at a random second of the speech
  released      as the released test draws: one pair per clip, the first second, NumPy's generator of seed 0
                over the clips. It takes scenes in the file system's order, which is not reproducible; here
                they are sorted by name
)";

struct Options {
  fs::path data;
  std::string split = "test";
  std::string draw = "every-target";
  std::optional<std::uint64_t> seed;
  std::optional<fs::path> output;
};

void run(const Options& options) {
  const PairDraw draw = draw_named(options.draw);
  if (draw == PairDraw::released && options.seed) {
    throw InputError("--seed", "the released draw has its own", "leave it out");
  }
  static_cast<void>(dataset_layout(options.data, DatasetLayout::soundspaces));
  const fs::path output =
      options.output.value_or(options.data / fmt::format("pairs-{}.json", options.split));
  if (!options.output && fs::exists(output)) {
    throw InputError(output.string(), "exists already",
                     "results are compared on it: choose another file with -o");
  }
  const SoundSpacesDataset dataset(soundspaces_options(options.data, options.split));
  const PairList list = draw_pair_list(dataset, draw, options.seed.value_or(1));
  write_file(output, text_of(list));
  fmt::print("wrote {}: {} pairs of {} clips\n", output.string(), list.pairs.size(),
             dataset.clips().size());
}

}  // namespace

void add_pairs_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "pairs", "Draw the pairs on which methods are compared, and write the list.");
  command
      ->add_option(
          "--data", options->data,
          "Folder of a data set in the layout of SoundSpaces-NVAS; the pairs of Replay-NVAS "
          "are drawn by evaluate")
      ->required();
  command->add_option("--split", options->split, "Split of the pairs")->capture_default_str();
  command->add_option("--draw", options->draw, "Rule of the draw; see below")
      ->check(CLI::IsMember({"every-target", "released"}))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "Seed of every-target (default: 1)");
  command->add_option("-o,--output", options->output,
                      "List to write (default: pairs-<split>.json in the folder)");
  command->footer(kFooter);
  command->callback([options] { run(*options); });
}

}  // namespace earpoint
