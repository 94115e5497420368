#include <earpoint/core/csv.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include <earpoint/error.h>

namespace earpoint {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  while (true) {
    const auto end = line.find(separator);
    cells.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return cells;
    line.remove_prefix(end + 1);
  }
}

std::string join(std::span<const std::string_view> columns) {
  std::string text;
  for (const std::string_view column : columns) {
    if (!text.empty()) text += ',';
    text += column;
  }
  return text;
}

double parse_number(std::string_view cell, char separator, const std::string& where,
                    std::string_view column) {
  double value = 0.0;
  std::string text(cell);
  if (separator != ',') std::replace(text.begin(), text.end(), ',', '.');
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string field = where + ", " + std::string(column);
  if (cell.empty()) throw InputError(field, "the cell is empty", "give a number");
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
    throw InputError(field, "expected a finite number, found '" + std::string(cell) + "'");
  }
  return value;
}

}  // namespace

std::string_view without_byte_order_mark(std::string_view text, const std::string& name) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    throw InputError(name, "is UTF-16 text", "save it as CSV in UTF-8");
  }
  return text;
}

char csv_separator(std::string_view header) {
  for (const char separator : {';', '\t'}) {
    if (header.find(separator) != std::string_view::npos) return separator;
  }
  return ',';
}

std::vector<NumberRow> parse_number_csv(std::string_view text, const std::string& name,
                                        std::span<const std::string_view> columns) {
  std::vector<NumberRow> rows;
  bool header_seen = false;
  char separator = ',';
  text = without_byte_order_mark(text, name);
  for (int line = 1; !text.empty(); ++line) {
    const auto end = text.find('\n');
    const std::string_view content = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (content.empty() || content.front() == '#') continue;

    const std::string where = name + ": line " + std::to_string(line);
    if (!header_seen) separator = csv_separator(content);
    const std::vector<std::string_view> cells = split(content, separator);
    if (!header_seen) {
      if (!std::equal(cells.begin(), cells.end(), columns.begin(), columns.end())) {
        throw InputError(where, "expected the header " + join(columns) + ", found '" +
                                    std::string(content.substr(0, 80)) + "'");
      }
      header_seen = true;
      continue;
    }
    if (cells.size() != columns.size()) {
      throw InputError(where, "expected " + std::to_string(columns.size()) + " cells, found " +
                                  std::to_string(cells.size()));
    }
    NumberRow& row = rows.emplace_back(NumberRow{line, {}});
    for (std::size_t i = 0; i < cells.size(); ++i) {
      row.values.push_back(parse_number(cells[i], separator, where, columns[i]));
    }
  }
  if (!header_seen) throw InputError(name, "is empty", "its first line must be " + join(columns));
  if (rows.empty()) throw InputError(name, "has no rows after its header");
  return rows;
}

}  // namespace earpoint
