#include <earpoint/render_files/picture_stream.h>

#include <earpoint/media/image_file.h>

namespace earpoint {

PictureStream::PictureStream(const std::filesystem::path& path) {
  if (probe_media(path).kind == MediaKind::picture) {
    image_ = std::make_shared<const Image>(read_image(path));
  } else {
    frames_.emplace(path);
  }
}

std::shared_ptr<const Image> PictureStream::nearest(double time_s) {
  if (frames_) image_ = std::make_shared<const Image>(frames_->frame_nearest(time_s));
  return image_;
}

PictureStream open_pictures(const std::optional<std::filesystem::path>& picture,
                            const std::filesystem::path& sound) {
  if (picture) return PictureStream(*picture);
  return probe_media(sound).kind == MediaKind::movie ? PictureStream(sound) : PictureStream();
}

}  // namespace earpoint
