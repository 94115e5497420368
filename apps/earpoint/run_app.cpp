#include "run_app.h"

#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

#include <earpoint/core/error.h>

int run_app(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::fprintf(stderr, "earpoint: %s; --help tells more\n", error.what());
    return 2;
  } catch (const earpoint::InputError& error) {
    std::fprintf(stderr, "earpoint: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "earpoint: internal error: %s\n", error.what());
    return 1;
  }
}
