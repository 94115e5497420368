#include "run_app.h"

#include "flag_advice.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>

#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

/// 0 if all that was printed has arrived, else 2.
int flushed() {
  errno = 0;
  std::cout.flush();
  const bool arrived = std::cout.good() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (arrived) return 0;
  std::fprintf(stderr, "earpoint: standard output cannot be written%s%s\n", errno != 0 ? ": " : "",
               errno != 0 ? std::strerror(errno) : "");
  return 2;
}

}  // namespace

int run_app(CLI::App& app, int argc, char** argv) {
  remove_partial_files_on_signals();
  try {
    app.parse(argc, argv);
    return flushed();
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help, --version
      app.exit(error);
      return flushed();
    }
    std::fprintf(stderr, "earpoint: %s; see --help\n", error.what());
    return 2;
  } catch (const InputError& error) {
    std::fprintf(stderr, "earpoint: %s\n", with_flags(error.what(), &given_command(app)).c_str());
    return 2;
  } catch (const std::exception& error) {
    if (std::ferror(stdout) != 0) return flushed();  // the error of a print before
    std::fprintf(stderr, "earpoint: internal error: %s\n", error.what());
    return 1;
  }
}

}  // namespace earpoint
