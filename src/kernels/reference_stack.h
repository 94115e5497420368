#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <earpoint/kernels/gated_stack.h>

namespace earpoint::kernels {

/// A gated stack with its weights, for tests.
struct StackExample {
  StackExample(int audio_channels, int channels, int conditioning_width,
               const std::vector<DilatedConvolution>& convolutions, std::uint64_t seed);
  StackExample(const StackExample&) = delete;
  StackExample& operator=(const StackExample&) = delete;

  GatedStackWeights weights;

 private:
  std::span<const float> draw(std::size_t size, double most);

  std::vector<std::vector<float>> storage_;
  std::uint64_t seed_;
};

/// The gated stack as docs/released-code.md defines it, sample by sample, in double. Slow; for
/// tests.
std::vector<double> reference_stack(const GatedStackWeights& weights, std::span<const float> source,
                                    std::span<const float> conditioning);

}  // namespace earpoint::kernels
