#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/network/checked_tensors.h>

namespace earpoint {

/// Checks a number of a description.
/// @throws InputError naming the field
void check_range(std::string_view where, std::string_view field, std::int64_t value,
                 std::int64_t least, std::int64_t most);

/// Names and shapes of a batch norm's four tensors.
void add_batch_norm(TensorShapes& shapes, const std::string& prefix, std::int64_t channels);

/// Two 3x3 convolutions with batch norms; where the width changes, a 1x1 convolution beside them.
void add_residual_block(TensorShapes& shapes, const std::string& name, std::int64_t from,
                        std::int64_t to);

/// ResNet-18 without pooling and classifier, as a list of modules under `prefix`.
/// @param image_channels  of what it looks at
/// @param channels        of its first stage: 64 in the published network
void add_resnet18(TensorShapes& shapes, const std::string& prefix, std::int64_t image_channels,
                  std::int64_t channels);

/// A layer with a bias for each of its outputs, the first axis of `weight`.
void add_layer(TensorShapes& shapes, const std::string& name, std::vector<std::int64_t> weight);

}  // namespace earpoint
