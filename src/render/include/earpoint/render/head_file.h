#pragma once

#include <string_view>

#include <earpoint/spatial/sofa_file.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// Head-related impulse responses as a safetensors file, which a page can read without a library
/// for SOFA's HDF5: the tensors `positions_m` [measurements][3], `responses`
/// [measurements][2][taps] and `delays_samples` [measurements][2], float32, and the metadata
/// `sample_rate_hz`.
[[nodiscard]] SafetensorsFile to_head_file(const SofaFile& head);

/// Whether a file is one of those, by its metadata.
[[nodiscard]] bool is_head_file(const SafetensorsFile& file);

/// @param where  stands for the file in messages
/// @throws InputError if a tensor is missing, has another shape, or has NaN or infinite values; if
///         the rate is not within 8 to 192 kHz
[[nodiscard]] SofaFile read_head_file(const SafetensorsFile& file, std::string_view where);

}  // namespace earpoint
