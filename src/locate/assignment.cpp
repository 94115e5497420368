#include <earpoint/locate/assignment.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <earpoint/error.h>

namespace earpoint {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A square matrix, with indices from 1 as in the method below. A forbidden pair costs more than
/// all allowed pairs together.
struct SquareCosts {
  std::size_t size = 0;
  double forbidden = 1.0;
  const std::vector<std::vector<double>>& costs;

  [[nodiscard]] double at(std::size_t row, std::size_t column) const {
    if (row > costs.size() || column > costs[row - 1].size()) return forbidden;
    const double cost = costs[row - 1][column - 1];
    return std::isfinite(cost) ? cost : forbidden;
  }
};

SquareCosts square(const std::vector<std::vector<double>>& costs) {
  SquareCosts result{.size = costs.size(), .forbidden = 1.0, .costs = costs};
  for (const std::vector<double>& row : costs) {
    EARPOINT_CHECK(row.size() == costs.front().size());
    result.size = std::max(result.size, row.size());
    for (const double cost : row) {
      if (std::isfinite(cost)) result.forbidden += 2.0 * std::abs(cost);
    }
  }
  return result;
}

/// Row of every column of a square matrix, both from 1; [0] is unused.
std::vector<std::size_t> rows_of_columns(const SquareCosts& costs) {
  const std::size_t n = costs.size;
  std::vector<double> row_price(n + 1, 0.0);
  std::vector<double> column_price(n + 1, 0.0);
  std::vector<std::size_t> row_of(n + 1, 0);
  for (std::size_t row = 1; row <= n; ++row) {
    // Grow the tree of cheapest alternating paths from this row until a free column is met.
    std::vector<double> least(n + 1, kInfinity);
    std::vector<std::size_t> from(n + 1, 0);
    std::vector<bool> is_done(n + 1, false);
    std::size_t column = 0;
    row_of[0] = row;
    do {
      is_done[column] = true;
      const std::size_t current = row_of[column];
      double step = kInfinity;
      std::size_t next = 0;
      for (std::size_t j = 1; j <= n; ++j) {
        if (is_done[j]) continue;
        const double reduced = costs.at(current, j) - row_price[current] - column_price[j];
        if (reduced < least[j]) {
          least[j] = reduced;
          from[j] = column;
        }
        if (least[j] < step) {
          step = least[j];
          next = j;
        }
      }
      for (std::size_t j = 0; j <= n; ++j) {
        if (is_done[j]) {
          row_price[row_of[j]] += step;
          column_price[j] -= step;
        } else {
          least[j] -= step;
        }
      }
      column = next;
    } while (row_of[column] != 0);
    // Swap the pairs along the path.
    while (column != 0) {
      row_of[column] = row_of[from[column]];
      column = from[column];
    }
  }
  return row_of;
}

}  // namespace

std::vector<std::optional<std::size_t>> cheapest_pairs(
    const std::vector<std::vector<double>>& costs) {
  std::vector<std::optional<std::size_t>> pairs(costs.size());
  if (costs.empty() || costs.front().empty()) return pairs;
  const std::vector<std::size_t> row_of = rows_of_columns(square(costs));
  for (std::size_t column = 1; column < row_of.size(); ++column) {
    const std::size_t row = row_of[column];
    if (row > costs.size() || column > costs.front().size()) continue;
    if (std::isfinite(costs[row - 1][column - 1])) pairs[row - 1] = column - 1;
  }
  return pairs;
}

}  // namespace earpoint
