#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/gtf/description.h>
#include <earpoint/gtf/weights.h>

namespace earpoint {

/// A tensor of each shape, filled in the order of names with numbers drawn evenly from low to high.
[[nodiscard]] std::map<std::string, Tensor> random_tensors(
    const std::map<std::string, std::vector<std::int64_t>>& shapes, RandomStream& random,
    double low, double high);

/// A gtf network that was never trained: numbers from -0.2 to 0.2, powers of its head's tables from
/// 0.5 to 0.9.
[[nodiscard]] GtfWeights random_gtf_weights(const GtfDescription& description);

/// The same, but with what learns at 0 and kernels that take the present frame of each ear: what it
/// hears comes out again, whatever the pose, within the trained range.
/// @param description  without delays, which would turn phases
[[nodiscard]] GtfWeights pass_through_gtf_weights(const GtfDescription& description);

}  // namespace earpoint
