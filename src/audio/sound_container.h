#pragma once

#include <filesystem>

namespace earpoint {

/// Refuses a WAV, W64 or OGG file that ends before its container says it does; libsndfile would
/// read such a file as a shorter sound. Lengths that a recorder left open because it could not
/// know them are accepted. Files of other formats pass: their decoders notice.
/// @throws InputError if the file is truncated
void check_container_is_whole(const std::filesystem::path& path);

}  // namespace earpoint
