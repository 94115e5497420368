#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace earpoint {

/// One line of a CSV file whose columns are all numbers.
struct NumberRow {
  int line = 0;                ///< counted from 1, for messages
  std::vector<double> values;  ///< one per column, all finite
};

/// Parses CSV text whose first line is exactly `columns`. Empty lines and lines that start with #
/// are skipped; blanks around cells and CRLF line ends are allowed.
///
/// @param name     stands for the file in messages
/// @param columns  the expected header
/// @throws InputError naming the line: wrong header, wrong number of cells, an empty cell, no
/// number,
///         not finite, or no row at all
std::vector<NumberRow> parse_number_csv(std::string_view text, const std::string& name,
                                        std::span<const std::string_view> columns);

}  // namespace earpoint
