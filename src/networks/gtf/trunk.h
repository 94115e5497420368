#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <earpoint/gtf/constants.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/kernels/aligned_floats.h>
#include <earpoint/kernels/dense.h>
#include <earpoint/kernels/frame_product.h>

namespace earpoint::gtf {

/// The dilated convolutions over frames, which see the present and the past. Takes frames in
/// blocks and remembers what later ones need.
class GtfTrunk {
 public:
  /// @param most_frames  in one block
  GtfTrunk(const GtfWeights& weights, std::ptrdiff_t most_frames);

  /// Forgets all frames.
  void reset();
  /// From here on. @param conditions  [conditioning width]
  void condition(std::span<const float> conditions);

  /// Allocates nothing.
  /// @param features  [frames][frame features]
  /// @param states    [frames][row()]; channels, then filling
  void run(const float* features, std::ptrdiff_t frames, float* states);

  [[nodiscard]] std::ptrdiff_t row() const { return input_.row(); }

 private:
  struct Layer {
    std::ptrdiff_t step = 1;
    kernels::FrameMatrix taps[gtf::kTrunkTaps];  // two steps back, one step back, now
    AlignedFloats bias;
    kernels::Dense film;
    std::vector<float> scale_and_shift;  // [2][channels]
    AlignedFloats memory;                // [2 * step + most frames][row]
  };

  std::ptrdiff_t channels_;
  std::ptrdiff_t inputs_;
  kernels::FrameMatrix input_;
  AlignedFloats input_bias_;
  std::vector<Layer> layers_;
  AlignedFloats sums_;  // [most frames][row]
};

}  // namespace earpoint::gtf
