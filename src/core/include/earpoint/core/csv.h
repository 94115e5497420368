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

/// The text behind a byte order mark, as spreadsheets write one.
/// @param name  stands for the file in the message
/// @throws InputError if the mark says that it is UTF-16
std::string_view without_byte_order_mark(std::string_view text, const std::string& name);

/// What separates the cells of a file with that header: a semicolon if there is one in it, else a
/// tab, else a comma.
char csv_separator(std::string_view header);

/// Parses CSV text whose first line is exactly `columns`. Empty lines and lines that start with #
/// are skipped; blanks around cells, CRLF line ends and a byte order mark are allowed. Cells are
/// separated by commas, semicolons or tabs; where it is not commas, numbers may have a decimal
/// comma.
///
/// @param name     stands for the file in messages
/// @param columns  the expected header
/// @throws InputError naming the line: wrong header, wrong number of cells, an empty cell, no
///         number, not finite, or no row at all
std::vector<NumberRow> parse_number_csv(std::string_view text, const std::string& name,
                                        std::span<const std::string_view> columns);

}  // namespace earpoint
