#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace earpoint {

enum class PictureFormat { png, jpeg };

/// By the first bytes; nothing if they begin neither a PNG nor a JPEG file. Private to the module.
std::optional<PictureFormat> picture_format(std::span<const std::byte> bytes);

}  // namespace earpoint
