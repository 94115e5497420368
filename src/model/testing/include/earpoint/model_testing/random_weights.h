#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/model/gtf.h>
#include <earpoint/model/weights.h>

namespace earpoint {

/// A tensor of each shape, filled in the order of names with numbers drawn evenly from low to high.
[[nodiscard]] std::map<std::string, Tensor> random_tensors(
    const std::map<std::string, std::vector<std::int64_t>>& shapes, RandomStream& random,
    double low, double high);

/// A gtf network that was never trained: numbers from -0.2 to 0.2, powers of its head's tables from
/// 0.5 to 0.9.
[[nodiscard]] GtfWeights random_gtf_weights(const GtfDescription& description);

}  // namespace earpoint
