#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <earpoint/image.h>

namespace earpoint {

/// A CSV file of numbers that grows by a line at a time and can be cut back to a step.
class NumberLog {
 public:
  /// Opens the file and drops the lines behind `last_step`, and any that is not whole.
  /// @param columns  the header; the first column is the step
  NumberLog(std::filesystem::path path, const std::string& columns, std::int64_t last_step);

  /// @param values  as many as there are columns; the first is the step
  void add(const std::vector<double>& values);

  /// Hands lines to the system.
  void flush();

  [[nodiscard]] const std::vector<std::vector<double>>& rows() const { return rows_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::filesystem::path path_;
  std::vector<std::vector<double>> rows_;
  std::unique_ptr<std::FILE, Close> file_;
};

/// A curve over clips seen.
struct CurvePoint {
  double clips = 0.0;
  double value = 0.0;
};

/// Loss (smoothed, and pale as it was) above validation error, over clips seen.
/// @param error_name  of the metric, ASCII
[[nodiscard]] Image plot_training(const std::vector<CurvePoint>& losses,
                                  const std::vector<CurvePoint>& errors,
                                  const std::string& error_name);

}  // namespace earpoint
