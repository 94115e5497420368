#include "offset_support.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace earpoint {

OffsetSupport::OffsetSupport(const std::vector<ArrivalError>& errors, double slope, double bin_s)
    : bin_s_(bin_s), support_(2 * kHalf + 1) {
  std::vector<double> histogram(support_.size());
  for (const ArrivalError& error : errors) {
    const double late_s = error.late_s - slope * error.since_s;
    if (std::abs(late_s) >= kHalf * bin_s) continue;
    histogram[kHalf + std::lround(late_s / bin_s)] += error.height;
  }
  for (std::ptrdiff_t bin = kSpread; bin <= 2 * kHalf - kSpread; ++bin) {
    const auto first = histogram.begin() + bin - kSpread;
    support_[bin] = std::accumulate(first, first + 2 * kSpread + 1, 0.0);
  }
  most_ = *std::ranges::max_element(support_);
}

double OffsetSupport::first_s() const {
  constexpr double kMuch = 0.6;
  if (most_ <= 0.0) return 0.0;
  std::ptrdiff_t first = kSpread;
  while (support_[first] < kMuch * most_) ++first;
  while (support_[first] < most_ && support_[first + 1] >= support_[first]) ++first;
  return static_cast<double>(first - kHalf) * bin_s_;
}

}  // namespace earpoint
