#pragma once

#include <vector>

#include <earpoint/evaluate/method.h>

namespace earpoint {

/// Oracles: the error that remains if part of the answer is known. They show how much of it each
/// kind of knowledge can remove. From the least to the most:
/// - `oracle-gain`: the source, each ear at the target's true level;
/// - `oracle-bands`: the source, every bin of its spectrum (512 points) in each ear at the target's
///   true level over the whole clip;
/// - `oracle-dry-direct`: the true dry speech by the true direct path (the first 4 ms of the
///   response), and a tail of noise that has the true response's energy per octave band and 10 ms,
///   which is what can be known of a room without individual reflections;
/// - `oracle-expected`: of many such tails the median magnitude in every bin and frame: nearly the
///   best Mag possible without knowing individual reflections, with a bad decay;
/// - `oracle-all`: the true dry speech by the true response, which is the target except for
///   rounding.
/// The last three need simulated data.
[[nodiscard]] std::vector<MethodEntry> oracle_methods();

}  // namespace earpoint
