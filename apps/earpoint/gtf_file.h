#pragma once

#include <filesystem>

namespace earpoint {

/// Writes the weight file of a small gtf network that was never trained.
/// @param picture_px  0: it does not look
/// @param geometry    false: it finds no speaker
/// @param texture     whether it is told a texture
void write_gtf_file(const std::filesystem::path& path, int picture_px = 32, bool geometry = true,
                    bool texture = false);

}  // namespace earpoint
