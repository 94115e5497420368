#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace earpoint {

enum class PictureFormat { png, jpeg };

/// By the first bytes; nothing if they begin neither a PNG nor a JPEG file. Private to the module.
std::optional<PictureFormat> picture_format(std::span<const std::byte> bytes);

/// What kind of picture that is not read they begin: "HEIC", "WebP", "GIF"...; nothing if none is
/// known.
std::optional<std::string_view> other_picture(std::span<const std::byte> bytes);

/// @throws InputError if they begin such a picture, with the kinds that are read
void refuse_other_picture(std::span<const std::byte> bytes, const std::string& name);

}  // namespace earpoint
