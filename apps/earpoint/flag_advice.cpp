#include "flag_advice.h"

#include <array>
#include <string_view>

#include <CLI/CLI.hpp>

namespace earpoint {
namespace {

/// Settings that messages of the libraries begin with.
constexpr std::array kSettings = std::to_array<std::string_view>(
    {"boxes", "clips", "design", "device", "draw", "figure", "host", "layout", "methods", "model",
     "pairs", "rule", "seconds", "shard", "unit"});

struct Advice {
  std::string_view phrase;  ///< as in the libraries' messages
  std::string_view flag;
  std::string_view value = {};
};

constexpr std::array kAdvice{
    Advice{"speaker's position", "--speaker", " x,y,z"},
    Advice{"speaker's box", "--speaker-box", " x0,y0,x1,y1"},
    Advice{"table of boxes", "--speaker-boxes", " FILE.csv"},
    Advice{"choose an audio stream", "--audio-stream"},
    Advice{"channel of each ear", "--binaural-channels"},
    Advice{"people detector", "--detector"},
    Advice{"use it for metrics", "--rt60-model"},
    Advice{"choose another port", "--port"},
    Advice{"close the ceiling", "--close-ceiling"},
    Advice{"length of its unit", "--unit"},
    Advice{"which axis points up", "--up"},
    Advice{"name it in the materials", "--materials"},
    Advice{"skip bad pairs", "--skip-bad"},
    Advice{"look up by relative pose", "--tf-index", " relative"},
    Advice{"another output folder", "--out"},
    Advice{"fewer cameras", "--cameras"},
    Advice{"fewer people", "--people"},
    Advice{"resume the training", "--resume"},
    Advice{"folder of speech", "--speech"},
    Advice{"its own shard", "--shard"},
    Advice{"fewer clips", "--count"},
    Advice{"name the clips", "--clips"},
    Advice{"fewer controls", "--controls"},
    Advice{"shorter clips", "--seconds"},
    Advice{"choose the layout", "--layout"},
    Advice{"longer responses", "--duration"},
};

bool has_flag(const CLI::App* command, std::string_view flag) {
  return command == nullptr || command->get_option_no_throw(std::string(flag)) != nullptr;
}

}  // namespace

std::string with_flags(const std::string& message, const CLI::App* command) {
  const std::string_view first = std::string_view(message).substr(0, message.find_first_of(": "));
  std::string text = message;
  for (const std::string_view setting : kSettings) {
    const std::string flag = "--" + std::string(setting);
    if (first == setting && has_flag(command, flag)) text.insert(0, "--");
  }
  std::string flags;
  for (const Advice& advice : kAdvice) {
    if (message.find(advice.phrase) == std::string::npos || !has_flag(command, advice.flag))
      continue;
    flags += flags.empty() ? "" : ", ";
    flags += std::string(advice.flag) + std::string(advice.value);
  }
  return flags.empty() ? text : text + " (" + flags + ")";
}

const CLI::App& given_command(const CLI::App& app) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().back();
  return *command;
}

}  // namespace earpoint
