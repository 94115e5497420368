#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include <earpoint/image.h>

namespace earpoint {

/// Reads a PNG or JPEG file; its first bytes, not its name, say which.
///
/// Whatever comes in (grey, palette, 1 to 16 bits, transparency, YCbCr) goes out as RGB. Samples of
/// other depths are scaled to 0..255 and rounded; transparent pixels are composited on black; the
/// Exif orientation is applied. Colour profiles are not: values are taken as sRGB.
///
/// @return  shape [height][width][3]
/// @throws  InputError if the file is missing, neither PNG nor JPEG, damaged, cut short, or larger
///          than 100 megapixels
[[nodiscard]] Image read_image(const std::filesystem::path& path);

/// Decodes a PNG or JPEG file that lies in memory, as read_image does.
/// @param where  what errors call it
/// @throws  InputError as read_image
[[nodiscard]] Image decode_image(std::span<const std::byte> bytes, std::string_view where);

/// @param image  not empty; 3 channels (RGB), or 1 (grey)
/// @return the bytes of a PNG file
[[nodiscard]] std::vector<std::byte> encode_png(const Image& image);

/// @param image  as encode_png()
/// @return the bytes of a JPEG file, as write_image() writes it
[[nodiscard]] std::vector<std::byte> encode_jpeg(const Image& image);

/// Finds out before long work whether write_image() can write there.
/// @throws InputError as write_image
void check_image_path(const std::filesystem::path& path);

/// Writes a picture, whole or not at all. The extension chooses the format: .png is lossless;
/// .jpg and .jpeg have full colour resolution (4:4:4) and high quality.
///
/// @param image  not empty; 3 channels (RGB), or 1 (grey; read_image gives it back as RGB)
/// @throws  InputError if the extension is another, or the file cannot be written
void write_image(const std::filesystem::path& path, const Image& image);

}  // namespace earpoint
