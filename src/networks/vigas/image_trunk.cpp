#include "image_trunk.h"

#include <string>

#include <earpoint/error.h>
#include <earpoint/vigas/description.h>

namespace earpoint {
namespace {

kernels::ResNet18 make_resnet(const ViGasWeights& weights, int threads) {
  EARPOINT_CHECK(weights.description.image_encoder.has_value());
  const ImageEncoderDescription& encoder = *weights.description.image_encoder;
  const kernels::TensorByName tensor = [&](const std::string& name) -> const Tensor& {
    return weights.at(name);
  };
  return {tensor, "visual_encoder", 3, encoder.height_px, encoder.width_px, threads};
}

kernels::Dense make_reduction(const ViGasWeights& weights) {
  const kernels::TensorByName tensor = [&](const std::string& name) -> const Tensor& {
    return weights.at(name);
  };
  const kernels::FoldedConvolution folded =
      kernels::fold_batch_norm(tensor, "conv1x1.0", "conv1x1.1", true);
  return {folded.weight, folded.bias};
}

}  // namespace

ImageTrunk::ImageTrunk(const ViGasWeights& weights, int threads)
    : resnet_(make_resnet(weights, threads)),
      reduction_(make_reduction(weights)),
      map_(static_cast<std::size_t>(resnet_.channels()) * resnet_.map_height() *
           resnet_.map_width()),
      pixel_(resnet_.channels()),
      reduced_(reduction_.outputs()) {}

void ImageTrunk::encode(std::span<const float> picture, std::span<float> feature) {
  const std::size_t pixels = map_.size() / pixel_.size();
  EARPOINT_CHECK(feature.size() == pixels * reduced_.size());
  resnet_.run(picture, map_);
  for (std::size_t at = 0; at < pixels; ++at) {
    for (std::size_t c = 0; c < pixel_.size(); ++c) pixel_[c] = map_[c * pixels + at];
    reduction_.apply(pixel_, reduced_);
    kernels::apply_relu(reduced_);
    for (std::size_t c = 0; c < reduced_.size(); ++c) feature[c * pixels + at] = reduced_[c];
  }
}

}  // namespace earpoint
