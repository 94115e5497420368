#include "completion.h"

#include <algorithm>
#include <span>
#include <string_view>
#include <utility>

#include <CLI/CLI.hpp>

namespace earpoint {
namespace {

/// The first sentence, on one line.
std::string first_sentence(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  std::ranges::replace(text, '\t', ' ');
  const auto end = text.find(". ");
  if (end != std::string::npos) text.resize(end);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

bool takes_value(const CLI::Option& option) {
  return option.get_type_size() != 0 && option.get_expected_max() > 0;
}

/// The words that an option names as its values; CLI11 has them only as text, like
/// "TEXT:{full,model}".
std::vector<std::string> fixed_choice(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto begin = type.find('{'), end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos || end < begin) return {};
  return CLI::detail::split(type.substr(begin + 1, end - begin - 1), ',');
}

const CLI::App* command_named(const CLI::App& app, std::string_view name) {
  for (const CLI::App* command : app.get_subcommands({})) {
    if (command->get_name() == name) return command;
  }
  return nullptr;
}

/// Where the words before the last one lead.
struct Place {
  const CLI::App* command = nullptr;
  const CLI::Option* expects_value = nullptr;  ///< the last word is its value
};

Place place_after(const CLI::App& app, std::span<const std::string> words) {
  Place place{.command = &app};
  for (const std::string& word : words) {
    // Bash makes a word of the sign in --option=value.
    if (word == "=") continue;
    if (std::exchange(place.expects_value, nullptr) != nullptr) continue;
    if (word.starts_with('-')) {
      const CLI::Option* option = place.command->get_option_no_throw(word);
      if (option != nullptr && takes_value(*option)) place.expects_value = option;
    } else if (const CLI::App* command = command_named(*place.command, word)) {
      place.command = command;
    }
  }
  return place;
}

void add_options(const CLI::App& command, std::vector<Completion>& found) {
  for (const CLI::Option* option : visible_options(command)) {
    const std::string meaning = first_sentence(option->get_description());
    for (const std::string& name : option->get_lnames()) found.push_back({"--" + name, meaning});
    for (const std::string& name : option->get_snames()) found.push_back({"-" + name, meaning});
  }
}

void add_words(const CLI::App& command, std::vector<Completion>& found) {
  for (const CLI::App* next : visible_commands(command)) {
    found.push_back({next->get_name(), first_sentence(next->get_description())});
  }
  for (const CLI::Option* option : command.get_options()) {
    if (!option->get_positional()) continue;
    for (const std::string& word : fixed_choice(*option)) found.push_back({word, ""});
  }
}

}  // namespace

std::vector<const CLI::App*> visible_commands(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_group().empty(); });
}

std::vector<const CLI::Option*> visible_options(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) {
    return option->nonpositional() && !option->get_group().empty();
  });
}

std::vector<Completion> complete(const CLI::App& app, const std::vector<std::string>& words) {
  std::string current = words.empty() ? "" : words.back();
  const auto before = std::span(words).first(words.empty() ? 0 : words.size() - 1);
  const Place place = place_after(app, before);
  if (current == "=") current.clear();
  std::vector<Completion> found;
  if (place.expects_value != nullptr) {
    for (const std::string& word : fixed_choice(*place.expects_value)) found.push_back({word, ""});
  } else if (current.starts_with('-')) {
    add_options(*place.command, found);
  } else {
    add_words(*place.command, found);
  }
  std::erase_if(found, [&](const Completion& it) { return !it.word.starts_with(current); });
  return found;
}

}  // namespace earpoint
