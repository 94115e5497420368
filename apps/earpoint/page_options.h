#pragma once

#include <cstdio>
#include <string_view>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <earpoint/serve/page_server.h>

namespace earpoint {

/// Adds --host and --port of a command that serves a page.
void add_page_options(CLI::App& command, PageAddress& address);

/// @return the address, with a token where other computers reach it
[[nodiscard]] PageAddress with_token(PageAddress address);

/// Prints where the page is, then serves it until the program is stopped.
/// @param server  a ClipServer or StudyServer at that address
/// @param what    before the address, e.g. "Listen at"
template <typename Server>
void serve_page(Server& server, PageAddress address, std::string_view what) {
  address.port = server.bind();
  fmt::print("{} {} (stop with Ctrl-C)\n", what, url_of(address));
  std::fflush(stdout);
  server.run();
}

}  // namespace earpoint
