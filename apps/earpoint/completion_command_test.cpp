#include "run_program.h"

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace earpoint {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// The words that the program offers; the last of `words` is the one to complete.
std::vector<std::string> offered(std::vector<std::string> words) {
  words.insert(words.begin(), {"complete", "--"});
  const ProgramOutcome outcome = run_earpoint(words);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  std::vector<std::string> found = lines_of(outcome.output);
  for (std::string& line : found) line.resize(line.find('\t'));
  return found;
}

bool contains(const std::vector<std::string>& words, const std::string& word) {
  return std::ranges::find(words, word) != words.end();
}

/// The names in the first column of a section of --help.
std::vector<std::string> helped(const std::vector<std::string>& command, const std::string& begin) {
  std::vector<std::string> words = command;
  words.push_back("--help");
  std::vector<std::string> names;
  for (const std::string& line : lines_of(run_earpoint(words).output)) {
    if (!line.starts_with("  " + begin) || line.starts_with("   ")) continue;
    std::istringstream columns(line);
    std::string name;
    columns >> name;
    std::istringstream parts(name);
    for (std::string part; std::getline(parts, part, ',');) names.push_back(part);
  }
  return names;
}

TEST(Completion, OffersEveryCommandAndOptionOfTheHelp) {
  const std::vector<std::string> commands = offered({""});
  ASSERT_TRUE(contains(commands, "render") && contains(commands, "simulate"));
  EXPECT_FALSE(contains(commands, "complete"));
  for (const std::string& command : commands) {
    if (command == "train") continue;  // another program
    const std::vector<std::string> options = offered({command, "-"});
    const std::vector<std::string> known = helped({command}, "-");
    EXPECT_TRUE(contains(options, "--help")) << command;
    for (const std::string& name : known) EXPECT_TRUE(contains(options, name)) << command << name;
  }
}

TEST(Completion, FollowsSubcommandsAndOptions) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(offered({"ren"}), Words{"render"});
  EXPECT_EQ(offered({"study", "mak"}), Words{"make"});
  EXPECT_EQ(offered({"completion", ""}), (Words{"bash", "zsh", "fish"}));
  EXPECT_EQ(offered({"render", "clip.mp4", "--textu"}), Words{"--texture"});
  EXPECT_EQ(offered({"render", "clip.mp4", "--texture", ""}), (Words{"natural", "mean"}));
  // As bash splits --texture=me.
  EXPECT_EQ(offered({"render", "--texture", "=", "me"}), Words{"mean"});
  EXPECT_EQ(offered({"render", "--texture", "="}), (Words{"natural", "mean"}));
  // A value that looks like a command is a value; files are left to the shell.
  EXPECT_EQ(offered({"render", "-o", "mean", "--textu"}), Words{"--texture"});
  EXPECT_EQ(offered({"render", "-o", ""}), Words{});
  EXPECT_EQ(offered({"nonsense", "--nonsense", "x"}), Words{});
}

TEST(Completion, BashUsesIt) {
  const std::string script = R"shell(eval "$("$0" completion bash)"
    COMP_WORDS=("$0" render --texture n) COMP_CWORD=3
    _earpoint "$0"
    printf '%s\n' "${COMPREPLY[@]}")shell";
  const ProgramOutcome outcome = run_program("/bin/bash", {"-c", script, EARPOINT_PROGRAM});
  EXPECT_EQ(outcome.output, "natural\n") << outcome.errors;
}

TEST(ManualPage, HasEveryOptionOfTheHelp) {
  const ProgramOutcome outcome = run_earpoint({"manual"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  std::string page = outcome.output;
  for (auto at = page.find("\\-"); at != std::string::npos; at = page.find("\\-", at)) {
    page.erase(at, 1);
  }
  EXPECT_TRUE(page.starts_with(".TH EARPOINT 1 "));
  for (const std::string& command : offered({""})) {
    EXPECT_NE(page.find(".SS earpoint " + command + "\n"), std::string::npos) << command;
    if (command == "train") continue;
    for (const std::string& name : helped({command}, "-")) {
      EXPECT_NE(page.find("\\fB" + name + "\\fR"), std::string::npos) << command << " " << name;
    }
  }
  // Lines that begin with a dot are man's own.
  for (const std::string& line : lines_of(page)) {
    if (line.starts_with('.')) {
      EXPECT_TRUE(line.find(' ') == std::string::npos || line.find(' ') <= 3) << line;
    }
    EXPECT_FALSE(line.starts_with('\'')) << line;
  }
}

}  // namespace

}  // namespace earpoint
