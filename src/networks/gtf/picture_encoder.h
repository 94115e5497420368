#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <earpoint/gtf/sight.h>
#include <earpoint/gtf/weights.h>
#include <earpoint/image.h>
#include <earpoint/kernels/aligned_floats.h>
#include <earpoint/kernels/dense.h>
#include <earpoint/kernels/frame_product.h>
#include <earpoint/vector3.h>

namespace earpoint::gtf {

/// A linear layer of that name.
[[nodiscard]] kernels::Dense dense_of(const GtfWeights& weights, const std::string& name);

/// From the view to its feature: strided convolutions with group norms, a linear layer.
class GtfPictureEncoder {
 public:
  /// @param weights  of a network that looks
  explicit GtfPictureEncoder(const GtfWeights& weights);

  /// Allocates nothing.
  /// @param picture  [3][size][size], 0 to 1
  /// @param feature  [picture_width]
  void encode(std::span<const float> picture, const std::optional<Box>& box,
              std::span<float> feature);

  /// What the picture shows on the way to a target, of the last picture looked at, in a network
  /// with sight points. Allocates nothing.
  /// @param target_m  in the camera's frame
  /// @param sight     [sight features]
  void encode_towards(const Vector3& target_m, std::span<float> sight);

 private:
  struct Layer {
    int channels_in = 0;
    int side_in = 0;
    kernels::FrameMatrix weight;  // of [row][column][channel] around a pixel
    AlignedFloats bias;
    std::vector<float> norm_scale;
    std::vector<float> norm_shift;
  };
  void convolve(const Layer& layer);

  int size_;
  std::vector<Layer> layers_;
  kernels::Dense output_;
  std::vector<float> map_;      // [pixel][channel]
  std::vector<float> columns_;  // [pixel][9 * channels]
  std::vector<float> rows_;     // [pixel][padded channels]
  std::vector<float> flat_;
  std::optional<kernels::Dense> sight_;
  std::vector<float> sight_map_;  // [pixel][channel]
  std::vector<GtfSight> places_;
  std::vector<float> there_;  // [channel]: the map at one place
};

}  // namespace earpoint::gtf
