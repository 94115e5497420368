#include "training_log.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

/// The numbers of a line, or none if one of them is invalid.
std::vector<double> numbers_in(std::string_view line) {
  std::vector<double> numbers;
  while (true) {
    const std::string_view cell = line.substr(0, line.find(','));
    double value = 0.0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc() || end != cell.data() + cell.size()) return {};
    numbers.push_back(value);
    if (cell.size() == line.size()) return numbers;
    line.remove_prefix(cell.size() + 1);
  }
}

std::string line_of(const std::vector<double>& values) {
  std::string line;
  // The shortest text that reads back as the same number.
  for (const double value : values) line += fmt::format("{}{}", line.empty() ? "" : ",", value);
  return line + "\n";
}

}  // namespace

NumberLog::NumberLog(fs::path path, const std::string& columns, std::int64_t last_step)
    : path_(std::move(path)) {
  std::string kept = columns + "\n";
  if (fs::exists(path_)) {
    const std::string text = read_text_file(path_);
    const auto count = static_cast<std::size_t>(std::ranges::count(columns, ',')) + 1;
    std::size_t start = text.find('\n');
    while (start != std::string::npos) {
      const std::size_t end = text.find('\n', start + 1);
      if (end == std::string::npos) break;  // a line without an end may be incomplete
      std::vector<double> row =
          numbers_in(std::string_view(text).substr(start + 1, end - start - 1));
      start = end;
      if (row.size() != count || row[0] > static_cast<double>(last_step)) continue;
      kept += line_of(row);
      rows_.push_back(std::move(row));
    }
  }
  write_file(path_, kept);
  file_.reset(std::fopen(path_.c_str(), "a"));
  if (!file_) throw InputError(path_.string(), "cannot be written");
}

void NumberLog::add(const std::vector<double>& values) {
  const std::string line = line_of(values);
  if (std::fwrite(line.data(), 1, line.size(), file_.get()) != line.size()) {
    throw InputError(path_.string(), "cannot be written", "is the disk full?");
  }
  rows_.push_back(values);
}

void NumberLog::flush() {
  if (std::fflush(file_.get()) != 0) {
    throw InputError(path_.string(), "cannot be written", "is the disk full?");
  }
}

}  // namespace earpoint
