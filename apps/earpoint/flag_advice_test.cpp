#include "flag_advice.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include <earpoint/error.h>

namespace earpoint {
namespace {

/// A command with a port and a layout.
struct Command {
  Command() {
    serve->add_option("--port", text);
    serve->add_option("--layout", text);
  }
  std::string with(const std::string& message) const { return with_flags(message, serve); }

  CLI::App app;
  CLI::App* serve = app.add_subcommand("serve", "");
  std::string text;
};

TEST(FlagAdvice, NamesTheFlagOfTheSettingThatAMessageBeginsWith) {
  const InputError error("layout", "expected soundspaces or replay, found x");
  EXPECT_EQ(Command().with(error.what()), "--layout: expected soundspaces or replay, found x");
  EXPECT_EQ(Command().with("shard: expected i/n"), "shard: expected i/n");
}

TEST(FlagAdvice, AddsTheFlagsThatAHintIsAboutAndTheCommandHas) {
  const InputError error("127.0.0.1:80", "cannot be served", "choose another port; 0 takes any");
  EXPECT_EQ(Command().with(error.what()),
            "127.0.0.1:80: cannot be served; choose another port; 0 takes any (--port)");
  EXPECT_EQ(Command().with("a: b; skip bad pairs"), "a: b; skip bad pairs");
  EXPECT_EQ(with_flags("a: b; give the speaker's position"),
            "a: b; give the speaker's position (--speaker x,y,z)");
}

TEST(FlagAdvice, FindsTheInnermostCommandThatWasGiven) {
  Command command;
  EXPECT_EQ(&given_command(command.app), &command.app);
  command.app.parse("serve --port 3");
  EXPECT_EQ(&given_command(command.app), command.serve);
}

}  // namespace
}  // namespace earpoint
