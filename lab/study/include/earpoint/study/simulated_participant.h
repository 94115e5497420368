#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace earpoint {

/// How a simulated participant finds what is closest to the reference.
enum class SimulatedRule {
  mag,    ///< the smallest BinauralMetrics::mag
  level,  ///< the smallest difference of level, in decibels, summed over the ears
  random,
};

/// @return "mag", "level" or "random"
[[nodiscard]] std::string_view name_of(SimulatedRule rule);
/// @throws InputError naming rule if there is none of that name
[[nodiscard]] SimulatedRule simulated_rule_named(std::string_view name);

struct SimulatedOptions {
  SimulatedRule rule = SimulatedRule::mag;
  std::uint64_t seed = 1;
  /// Hears the sum of both channels at both ears in the headphone check.
  bool has_loudspeakers = false;
  std::string label{};
};

/// What became of one.
struct SimulatedOutcome {
  std::string participant;
  bool passed_headphones = false;
  int answers = 0;
};

/// Takes part in a study from its first page to its last, as a browser does: by HTTP, and by what
/// it hears in the sounds that it gets. It is marked as simulated by its rule. Ratings are 100 for
/// no difference from the reference and 0 for the largest of a page.
/// @param port  of 127.0.0.1, where a StudyServer serves
/// @throws InputError if the server refuses something or does not answer
SimulatedOutcome take_part(int port, const SimulatedOptions& options);

}  // namespace earpoint
