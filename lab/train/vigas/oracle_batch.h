#pragma once

#include <filesystem>

#include <earpoint/train/training_batch.h>
#include <earpoint/vigas/description.h>
#include <earpoint/weights/safetensors.h>

namespace earpoint {

/// Test support: the inputs that the released code was run on, as a batch.
/// @param file  src_wav, perhaps tgt_wav, src_rgb_u8 and the network's inputs by name
TrainingBatch oracle_batch(const SafetensorsFile& file, const ViGasDescription& description);

/// Where the large reference files lie, or empty.
std::filesystem::path oracle_folder();

}  // namespace earpoint
