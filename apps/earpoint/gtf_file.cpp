#include "gtf_file.h"

#include <earpoint/gtf/description.h>
#include <earpoint/network/weights.h>
#include <earpoint/network_testing/random_weights.h>

namespace earpoint {

void write_gtf_file(const std::filesystem::path& path, int picture_px, bool geometry,
                    bool texture) {
  GtfDescription description;
  description.channels = 8;
  description.layers = 2;
  description.bands = 10;
  description.picture_px = picture_px;
  description.geometry = description.delays = geometry;
  description.texture = texture;
  description.highpass_cutoff_hz = 80.0;
  write_safetensors(path, to_weight_file(random_gtf_weights(description)));
}

}  // namespace earpoint
