#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <earpoint/core/image.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/kernels/aligned_floats.h>
#include <earpoint/kernels/dense.h>
#include <earpoint/kernels/frame_product.h>

namespace earpoint::kernels {

/// x / (1 + e^-x), in place.
void apply_silu(std::span<float> values);

/// A linear layer of that name.
[[nodiscard]] Dense dense_of(const GtfWeights& weights, const std::string& name);

/// From the view to its feature: strided convolutions with group norms, a linear layer.
class GtfPictureEncoder {
 public:
  /// @param weights  of a network that looks
  explicit GtfPictureEncoder(const GtfWeights& weights);

  /// Allocates nothing.
  /// @param picture  [3][size][size], 0 to 1
  /// @param feature  [picture_width]
  void look(std::span<const float> picture, const std::optional<Box>& box,
            std::span<float> feature);

 private:
  struct Layer {
    int channels_in = 0;
    int side_in = 0;
    FrameMatrix weight;  // of [row][column][channel] around a pixel
    AlignedFloats bias;
    std::vector<float> norm_scale;
    std::vector<float> norm_shift;
  };
  void convolve(const Layer& layer);

  int size_;
  std::vector<Layer> layers_;
  Dense output_;
  std::vector<float> map_;      // [pixel][channel]
  std::vector<float> columns_;  // [pixel][9 * channels]
  std::vector<float> rows_;     // [pixel][padded channels]
  std::vector<float> flat_;
};

}  // namespace earpoint::kernels
