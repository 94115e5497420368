#include <earpoint/media/media.h>

#include "container.h"
#include "exif.h"
#include "picture.h"

#include <array>
#include <fstream>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/media/image_file.h>

namespace earpoint {
namespace {

std::optional<PictureFormat> picture_format_of(const std::filesystem::path& path) {
  // Reading from a pipe could wait for ever.
  if (!std::filesystem::is_regular_file(path)) return std::nullopt;
  std::array<std::byte, 16> head{};
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(head.data()), head.size());
  const auto bytes = std::span(head).first(static_cast<std::size_t>(file.gcount()));
  refuse_other_picture(bytes, path.string());
  return picture_format(bytes);
}

MediaInfo describe_picture_file(const std::filesystem::path& path, PictureFormat format) {
  const std::vector<std::byte> bytes = read_file(path);
  const Image image = decode_image(bytes, path.string());
  MediaInfo info;
  info.kind = MediaKind::picture;
  info.format = format == PictureFormat::png ? "png" : "jpeg";
  StreamInfo& stream = info.streams.emplace_back();
  stream.kind = StreamKind::video;
  stream.codec = format == PictureFormat::png ? "png" : "mjpeg";
  stream.width = image.width();
  stream.height = image.height();
  if (const auto focal_length = read_exif(bytes).focal_length_35mm) {
    stream.horizontal_fov_rad = horizontal_fov_rad(*focal_length, image.width(), image.height());
  }
  return info;
}

}  // namespace

const StreamInfo* MediaInfo::preferred(StreamKind wanted) const {
  const StreamInfo* first = nullptr;
  for (const StreamInfo& stream : streams) {
    if (stream.kind != wanted) continue;
    if (stream.is_default) return &stream;
    if (first == nullptr) first = &stream;
  }
  return first;
}

MediaInfo probe_media(const std::filesystem::path& path) {
  if (const auto format = picture_format_of(path)) return describe_picture_file(path, *format);
  return ffmpeg::InputContainer(path).describe();
}

}  // namespace earpoint
