#pragma once

#include <memory>
#include <span>
#include <vector>

namespace earpoint {

/// Full linear convolution: y[n] = sum_k a[k] b[n - k].
/// @return  shape [a.size() + b.size() - 1]; empty if either is empty
/// Cost: direct if one of them is short, otherwise O(n log m) by blocks of Fourier transforms in
/// float: the error is about 1e-7 of the largest block's root-mean-square.
[[nodiscard]] std::vector<float> convolve(std::span<const float> a, std::span<const float> b);

/// Convolution of sound that arrives in blocks of one size, without delay: what has come out after
/// k blocks is the first k blocks of the whole convolution. The impulse response is cut into
/// partitions of one block each, whose spectra are multiplied and summed.
/// No allocation after construction. One object per stream.
/// Source: Stockham, AFIPS 28 (1966); Wefers, Partitioned convolution algorithms (2015), 5.3.
class PartitionedConvolver {
 public:
  /// @param impulse_response  shape [taps], at least one
  /// @param block_size        > 0
  PartitionedConvolver(std::span<const float> impulse_response, int block_size);
  ~PartitionedConvolver();
  PartitionedConvolver(PartitionedConvolver&&) noexcept;
  PartitionedConvolver& operator=(PartitionedConvolver&&) noexcept;

  [[nodiscard]] int block_size() const;

  /// @param in   shape [block_size], the next samples
  /// @param out  shape [block_size]; may be the same memory
  void process(std::span<const float> in, std::span<float> out);

  /// Forgets all samples.
  void reset();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace earpoint
