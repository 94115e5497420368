#pragma once

#include "stack_parameters.h"

#include <cstddef>
#include <functional>
#include <memory>

namespace earpoint::training {

/// The gated stack of ViGAS, from the source's sound to the target's, and its gradient. Samples are
/// computed some hundred at a time, through all of a layer, while they are in the cache; channels
/// lie side by side, so that taps of a convolution are whole rows whatever the dilation.
///
/// Threads work on clips of their own if there are enough, else on parts of them. The same number
/// of threads gives the same numbers.
class FusedStack {
 public:
  /// Calls work(begin, end, thread) so that all of 0..count is done, thread by thread in ascending
  /// parts that depend on the numbers alone, and returns when all are done.
  using ParallelLoop = std::function<void(
      std::ptrdiff_t count,
      const std::function<void(std::ptrdiff_t begin, std::ptrdiff_t end, int thread)>& work)>;

  /// @param threads  as many as the loop uses at most
  FusedStack(StackShape shape, int threads, ParallelLoop loop);

  ~FusedStack();

  /// @param source, output  [clips][audio channels][samples]
  /// @param keep            what backward() needs
  void forward(const StackParameters<const float>& weights, const float* source,
               std::ptrdiff_t clips, std::ptrdiff_t samples, bool keep, float* output);

  /// Gradient by all parameters, after a forward() that kept, and once for each.
  /// @param by_output  the gradient by the output
  /// @param gradients  [threads][all parameters one after the other], zeros; their sum over the
  ///                   threads is the gradient
  void backward(const StackParameters<const float>& weights, const TransposedParameters& transposed,
                const float* source, const float* by_output, float* gradients);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint::training
