#pragma once

#include <string>
#include <vector>

namespace earpoint {

/// What one instruction set of this processor can do at most.
struct FmaPeak {
  std::string instruction_set;
  double gflops = 0.0;  ///< all threads together
};

/// Multiply-adds on registers alone, with as many independent sums as hide their latency: the
/// most single-precision operations that `threads` threads reach at once. Two operations each.
/// @param threads  > 0
/// @return  one entry per instruction set that was compiled and that the processor has
std::vector<FmaPeak> measure_fma_peaks(int threads);

}  // namespace earpoint
