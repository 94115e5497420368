#include "gtf_file.h"

#include <cstddef>
#include <string>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/model/gtf.h>

namespace earpoint {

void write_gtf_file(const std::filesystem::path& path, int picture_px, bool geometry) {
  GtfDescription description;
  description.channels = 8;
  description.layers = 2;
  description.bands = 10;
  description.picture_px = picture_px;
  description.geometry = description.delays = geometry;
  description.highpass_cutoff_hz = 80.0;
  GtfWeights weights{description, {}, {}};
  RandomStream random(1);
  for (const auto& [name, shape] : required_tensors(description)) {
    std::vector<float> values(static_cast<std::size_t>(element_count(shape).value()));
    // Powers must be positive.
    const double low = name.find("power") != std::string::npos ? 0.5 : -0.2;
    for (float& value : values) value = static_cast<float>(random.uniform(low, low + 0.4));
    weights.tensors[name] = make_tensor<float>(values, shape);
  }
  write_safetensors(path, gtf_weight_file(weights));
}

}  // namespace earpoint
