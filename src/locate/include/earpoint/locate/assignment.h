#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace earpoint {

/// Pairs rows with columns so that as many as possible are paired and, among those pairings, the
/// sum of their costs is smallest.
/// @param costs  [rows][columns], rectangular; finite, or infinity for a pair that must not be
/// @return       for every row its column, or nothing
/// Source: the Hungarian method by shortest augmenting paths (Jonker and Volgenant, Computing 38,
/// 1987). Cost: O(n^3) for n rows and columns.
[[nodiscard]] std::vector<std::optional<std::size_t>> cheapest_pairs(
    const std::vector<std::vector<double>>& costs);

}  // namespace earpoint
