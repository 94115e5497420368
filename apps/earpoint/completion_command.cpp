#include "completion_command.h"

#include "completion.h"
#include "manual.h"

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace earpoint {
namespace {

constexpr const char* kFooter = R"(
The packages install these scripts. By hand:
  bash   earpoint completion bash > ~/.local/share/bash-completion/completions/earpoint
  zsh    earpoint completion zsh > DIR/_earpoint, in a DIR of $fpath
  fish   earpoint completion fish > ~/.config/fish/completions/earpoint.fish
)";

constexpr const char* kBash =
    R"script(# Completion of earpoint for bash; written by: earpoint completion bash
_earpoint() {
  local word rest
  COMPREPLY=()
  while IFS=$'\t' read -r word rest; do
    [ -z "$word" ] || COMPREPLY+=("$word")
  done <<<"$("${1/#\~/$HOME}" complete -- "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)"
}
complete -o default -F _earpoint earpoint
)script";

constexpr const char* kZsh = R"script(#compdef earpoint
# Completion of earpoint for zsh; written by: earpoint completion zsh
_earpoint() {
  local -a found
  local word rest
  while IFS=$'\t' read -r word rest; do
    [[ -z $word ]] || found+=("${word//:/\\:}:${rest//:/\\:}")
  done <<<"$("${(Q)words[1]}" complete -- "${(@Q)words[2,CURRENT]}" 2>/dev/null)"
  if (( $#found )); then
    _describe earpoint found
  else
    _files
  fi
}
if [ "$funcstack[1]" = _earpoint ]; then
  _earpoint "$@"
else
  compdef _earpoint earpoint
fi
)script";

constexpr const char* kFish =
    R"script(# Completion of earpoint for fish; written by: earpoint completion fish
function __earpoint_complete
    set -l words (commandline -opc) (commandline -ct)
    $words[1] complete -- $words[2..-1] 2>/dev/null
end
complete -c earpoint -n 'test (count (__earpoint_complete)) -gt 0' -f
complete -c earpoint -a '(__earpoint_complete)'
)script";

void print_script(const std::string& shell) {
  fmt::print("{}", shell == "bash" ? kBash : shell == "zsh" ? kZsh : kFish);
}

}  // namespace

void add_completion_commands(CLI::App& app) {
  auto shell = std::make_shared<std::string>();
  CLI::App* completion = app.add_subcommand(
      "completion", "Print a script that completes earpoint's commands in a shell.");
  completion->add_option("shell", *shell, "Shell")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  completion->footer(kFooter);
  completion->callback([shell] { print_script(*shell); });

  CLI::App* manual = app.add_subcommand(
      "manual", "Print the manual page, as `earpoint manual | man -l -` shows it.");
  manual->callback([&app] { fmt::print("{}", manual_page(app, EARPOINT_VERSION)); });
}

bool answer_completion(const CLI::App& app, std::span<char* const> arguments) {
  if (arguments.size() < 2 || std::string_view(arguments[1]) != "complete") return false;
  std::vector<std::string> words(arguments.begin() + 2, arguments.end());
  if (!words.empty() && words.front() == "--") words.erase(words.begin());
  for (const Completion& it : complete(app, words)) fmt::print("{}\t{}\n", it.word, it.meaning);
  return true;
}

}  // namespace earpoint
