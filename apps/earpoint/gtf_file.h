#pragma once

#include <filesystem>

namespace earpoint {

/// Writes the weight file of a small gtf network that was never trained.
/// @param picture_px  width and height of its picture input; 0: none
/// @param geometry    GtfDescription::geometry
/// @param texture     GtfDescription::texture
void write_gtf_file(const std::filesystem::path& path, int picture_px = 32, bool geometry = true,
                    bool texture = false);

}  // namespace earpoint
