#include "exif.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace earpoint {
namespace {

using Bytes = std::span<const std::byte>;

std::uint64_t number(Bytes bytes, bool is_little_endian) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const std::byte byte = bytes[is_little_endian ? bytes.size() - 1 - i : i];
    value = value << 8 | std::to_integer<std::uint64_t>(byte);
  }
  return value;
}

bool is_at(Bytes bytes, std::size_t position, std::string_view text) {
  return position + text.size() <= bytes.size() &&
         std::memcmp(bytes.data() + position, text.data(), text.size()) == 0;
}

/// Exif data are a small TIFF file: directories of entries of a tag, a type, a count and a value.
class TiffReader {
 public:
  explicit TiffReader(Bytes tiff) : tiff_(tiff), is_little_(is_at(tiff, 0, "II")) {}

  void read(Exif& exif) const {
    if (tiff_.size() < 8) return;
    read_directory(at(4, 4), exif, /*may_descend=*/true);
  }

 private:
  static constexpr std::size_t kEntry = 12;

  [[nodiscard]] std::uint64_t at(std::size_t position, std::size_t count) const {
    return number(tiff_.subspan(position, count), is_little_);
  }

  void read_directory(std::size_t position, Exif& exif, bool may_descend) const {
    if (position + 2 > tiff_.size()) return;
    const std::size_t entries = at(position, 2);
    position += 2;
    for (std::size_t i = 0; i < entries && position + kEntry <= tiff_.size(); ++i) {
      const std::uint64_t tag = at(position, 2);
      const std::uint64_t short_value = at(position + 8, 2);
      if (tag == 0x0112 && short_value >= 1 && short_value <= 8) {
        exif.orientation = static_cast<int>(short_value);
      }
      if (tag == 0xA405 && short_value > 0) {
        exif.focal_length_35mm = static_cast<double>(short_value);
      }
      if (tag == 0x8769 && may_descend) read_directory(at(position + 8, 4), exif, false);
      position += kEntry;
    }
  }

  Bytes tiff_;
  bool is_little_;
};

/// Chunks of a length, a name, the content and a checksum.
Bytes exif_of_png(Bytes png) {
  for (std::size_t position = 8; position + 12 <= png.size();) {
    const std::size_t length = number(png.subspan(position, 4), false);
    if (length > png.size() - position - 12) break;
    if (is_at(png, position + 4, "eXIf")) return png.subspan(position + 8, length);
    position += 12 + length;
  }
  return {};
}

/// Segments of a marker, a length that counts itself, and the content, up to the picture.
Bytes exif_of_jpeg(Bytes jpeg) {
  constexpr std::string_view kMark("Exif\0\0", 6);
  for (std::size_t position = 2; position + 4 <= jpeg.size();) {
    const std::uint64_t marker = number(jpeg.subspan(position, 2), false);
    const std::size_t length = number(jpeg.subspan(position + 2, 2), false);
    if (marker < 0xff01 || marker == 0xffda || length < 2) break;
    if (position + 2 + length > jpeg.size()) break;
    if (marker == 0xffe1 && is_at(jpeg, position + 4, kMark) && length >= 2 + kMark.size()) {
      return jpeg.subspan(position + 4 + kMark.size(), length - 2 - kMark.size());
    }
    position += 2 + length;
  }
  return {};
}

}  // namespace

Exif read_exif(Bytes picture) {
  Exif exif;
  const bool is_png = is_at(picture, 1, "PNG");
  TiffReader(is_png ? exif_of_png(picture) : exif_of_jpeg(picture)).read(exif);
  return exif;
}

double horizontal_fov_rad(double focal_length_35mm, int width, int height) {
  constexpr double kFilmDiagonalMm = 43.27;
  const double half_diagonal = kFilmDiagonalMm / (2.0 * focal_length_35mm);
  return 2.0 * std::atan(half_diagonal * width / std::hypot(width, height));
}

}  // namespace earpoint
