#pragma once

#include <vector>

#include <earpoint/evaluate/method.h>

namespace earpoint {

/// A ladder of oracles: what would be reached if part of the answer were known, so that one sees
/// how much of the way to zero is to be had by what kind of knowledge. From the lowest rung up:
/// - `oracle-gain`: the source, each ear at the target's true level;
/// - `oracle-bands`: the source, every bin of its spectrum (512 points) in each ear at the target's
///   true level over the whole clip;
/// - `oracle-dry-direct`: the true dry speech by the true direct path (the first 4 ms of the
///   response), and a tail of noise that has the true response's energy per octave band and 10 ms,
///   which is what one can know of a room without the single reflections;
/// - `oracle-expected`: of many such tails the median magnitude in every bin and frame: nearly the
///   best answer by Mag for who does not know the single reflections, and a bad one by decay;
/// - `oracle-all`: the true dry speech by the true response, which is the target but for rounding.
/// The last three need simulated data.
[[nodiscard]] std::vector<MethodEntry> oracle_methods();

}  // namespace earpoint
