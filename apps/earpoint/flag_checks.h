#pragma once

#include <CLI/CLI.hpp>

namespace earpoint {

/// For flags like --seed: a whole number, not negative, of at most 64 bits.
CLI::Validator whole_number();

}  // namespace earpoint
