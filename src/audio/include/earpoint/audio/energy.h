#pragma once

#include <span>

namespace earpoint {

/// Sum of squares, in the order of the samples. @param signal  [samples]
[[nodiscard]] inline double energy(std::span<const float> signal) {
  double sum = 0.0;
  for (const float sample : signal) sum += double{sample} * sample;
  return sum;
}

}  // namespace earpoint
