// Draws pictures of people in simulated homes, with boxes, for configs/people.json to learn from.
#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/generate/people_pictures.h>
#include <earpoint/scene/model_pack.h>

int main(int argc, char** argv) try {
  earpoint::PeoplePictureOptions options;
  CLI::App app(
      "Renders pictures of people in simulated homes, with boxes. An interrupted run continues.");
  app.add_option("--out", options.out, "Output folder")->required();
  app.add_option("--seed", options.seed, "The same seed gives the same pictures")
      ->capture_default_str();
  app.add_option("--train-homes", options.train_homes)
      ->check(CLI::Range(1, 9999))
      ->capture_default_str();
  app.add_option("--val-homes", options.val_homes)
      ->check(CLI::Range(1, 9999))
      ->capture_default_str();
  app.add_option("--test-homes", options.test_homes)
      ->check(CLI::Range(1, 9999))
      ->capture_default_str();
  app.add_option("--groups", options.groups, "Groups of people in each home")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option("--views", options.views, "Pictures of each group")
      ->check(CLI::Range(1, 10))
      ->capture_default_str();
  app.add_option("--split", options.split, "Render only the homes of this split")
      ->check(CLI::IsMember({"train", "val", "test"}));
  app.add_option("--jobs", options.jobs, "Homes in parallel")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  earpoint::remove_partial_files_on_signals();
  earpoint::ModelPack pack = earpoint::installed_models();
  if (pack.figures.empty()) {
    fmt::print(stderr,
               "earpoint-people-pictures: no figures are installed (./dev assets); "
               "mannequins replace them\n");
  }
  const earpoint::FurnitureLibrary furniture(std::move(pack.furniture));
  const earpoint::FigureLibrary figures(std::move(pack.figures));
  earpoint::draw_people_pictures(options, furniture, figures, [](int done, int all) {
    fmt::print("{} of {} homes\n", done, all);
    std::fflush(stdout);
  });
  return 0;
} catch (const earpoint::InputError& error) {
  fmt::print(stderr, "earpoint-people-pictures: {}\n", error.what());
  return 2;
} catch (const std::exception& error) {
  fmt::print(stderr, "earpoint-people-pictures: {}\n", error.what());
  return 1;
}
