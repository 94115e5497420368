#pragma once

#include <cstddef>
#include <vector>

namespace earpoint {

/// By how much a time of arrival deviates from what the fit expects, chosen or not.
struct ArrivalError {
  double since_s = 0.0;  ///< on the device's clock, from its middle
  double late_s = 0.0;   ///< later than expected
  double height = 0.0;   ///< of the correlation's peak, 0 to 1
};

/// How many times of arrival support each offset of a clock, given the error of its drift.
class OffsetSupport {
 public:
  /// Offsets within so many bins of each other support each other.
  static constexpr std::ptrdiff_t kSpread = 3;

  /// @param slope  error of the clock's rate, seconds per second
  /// @param bin_s  resolution; offsets up to 120 bins are looked at
  OffsetSupport(const std::vector<ArrivalError>& errors, double slope, double bin_s);

  /// The sum of heights that support the best offset.
  [[nodiscard]] double most() const { return most_; }

  /// A wall behind a camera reflects everybody's voice equally late, but nothing comes before the
  /// direct sound: the first offset with much support, up to its top.
  /// @return seconds; 0 without any support
  [[nodiscard]] double first_s() const;

 private:
  static constexpr std::ptrdiff_t kHalf = 120;  // bins
  double bin_s_;
  std::vector<double> support_;
  double most_ = 0.0;
};

}  // namespace earpoint
