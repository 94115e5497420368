#include "manual.h"

#include "completion.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace earpoint {
namespace {

constexpr const char* kRest = R"(.SH ENVIRONMENT
.TP
.B EARPOINT_MODELS_DIR
Folder of the models, instead of the installed ones.
.TP
.B EARPOINT_DATA_DIR
Folder of furniture, people and speech for simulated homes. Default: earpoint in $XDG_DATA_HOME, or in ~/.local/share.
.SH EXIT STATUS
.TP
.B 0
Success.
.TP
.B 1
An internal error, or too little memory.
.TP
.B 2
Wrong use, or bad input: one line on standard error says where, what is wrong and what to do.
)";

/// Text that man prints as it stands.
std::string escaped(std::string_view text) {
  std::string result;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) result += "\\&";
    line_begins = c == '\n';
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
  }
  return result;
}

std::string bold(const std::string& text) { return "\\fB" + escaped(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + escaped(text) + "\\fR"; }

/// The lines of a block whose line breaks are meant, like examples.
std::string as_it_stands(const std::string& text) {
  if (text.empty()) return "";
  std::string_view block = text;
  while (block.starts_with('\n')) block.remove_prefix(1);
  while (block.ends_with('\n')) block.remove_suffix(1);
  return fmt::format(".PP\n.EX\n{}\n.EE\n", escaped(block));
}

/// "-o, --output TEXT", and what --help says behind it.
std::string heading_of(const CLI::Option& option) {
  std::string names;
  const auto add = [&](const std::string& name) {
    names += (names.empty() ? "" : ", ") + bold(name);
  };
  if (option.get_positional()) add(option.get_name());
  for (const std::string& name : option.get_snames()) add("-" + name);
  for (const std::string& name : option.get_lnames()) add("--" + name);
  if (option.get_type_size() == 0) return names;
  if (!option.get_type_name().empty()) names += " " + italic(option.get_type_name());
  if (option.get_expected_max() == CLI::detail::expected_max_vector_size) names += " ...";
  if (!option.get_default_str().empty()) {
    names += escaped(fmt::format(" (default: {})", option.get_default_str()));
  }
  if (option.get_required()) names += " (required)";
  return names;
}

void add_option(const CLI::Option& option, std::string& page) {
  page += fmt::format(".TP\n{}\n{}\n", heading_of(option), escaped(option.get_description()));
}

/// A command's options in the groups and the order of --help.
void add_options(const CLI::App& command, std::string& page) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional() && !option->get_group().empty()) add_option(*option, page);
  }
  const std::vector<const CLI::Option*> options = visible_options(command);
  for (const std::string& group : command.get_groups()) {
    const auto in_group = [&](const CLI::Option* option) { return option->get_group() == group; };
    if (std::ranges::none_of(options, in_group)) continue;
    page += fmt::format(".PP\n{}:\n", bold(group));
    for (const CLI::Option* option : options) {
      if (in_group(option)) add_option(*option, page);
    }
  }
}

void add_command(const CLI::App& command, const std::string& name, std::string& page) {
  page += fmt::format(".SS {}\n{}\n", escaped(name), escaped(command.get_description()));
  add_options(command, page);
  page += as_it_stands(command.get_footer());
  for (const CLI::App* next : visible_commands(command)) {
    add_command(*next, name + " " + next->get_name(), page);
  }
}

/// "Earpoint: hear a moment." becomes "hear a moment", as whatis lists it.
std::string purpose_of(const CLI::App& app) {
  std::string text = app.get_description();
  if (const auto colon = text.find(": "); colon != std::string::npos) text.erase(0, colon + 2);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

}  // namespace

std::string manual_page(const CLI::App& app, const std::string& version) {
  const std::string& name = app.get_name();
  std::string title = name;
  std::ranges::transform(title, title.begin(), [](unsigned char c) { return std::toupper(c); });
  std::string page = fmt::format(".TH {} 1 \"\" \"{} {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n",
                                 title, name, escaped(version), name, escaped(purpose_of(app)));
  page +=
      fmt::format(".SH SYNOPSIS\n{} {} [{} ...]\n.br\n{} {} {}\n", bold(name), italic("COMMAND"),
                  italic("ARGUMENT"), bold(name), italic("COMMAND"), bold("--help"));
  page += fmt::format(".SH DESCRIPTION\n{}\n", escaped(app.get_description()));
  for (const CLI::App* command : visible_commands(app)) {
    page += fmt::format(".TP\n{}\n{}\n", bold(command->get_name()),
                        escaped(command->get_description()));
  }
  page += ".SH OPTIONS\n";
  for (const CLI::Option* option : visible_options(app)) add_option(*option, page);
  page += ".SH COMMANDS\n";
  for (const CLI::App* command : visible_commands(app)) {
    add_command(*command, name + " " + command->get_name(), page);
  }
  return page + kRest;
}

}  // namespace earpoint
