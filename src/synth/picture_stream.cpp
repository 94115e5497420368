#include <earpoint/synth/picture_stream.h>
#include <earpoint/video/image_file.h>

namespace earpoint {

PictureStream::PictureStream(const std::filesystem::path& path) {
  if (probe_media(path).kind == MediaKind::picture) {
    image_ = read_image(path);
  } else {
    frames_.emplace(path);
  }
}

const Image* PictureStream::nearest(double time_s) {
  if (frames_) image_ = frames_->frame_nearest(time_s);
  return image_.empty() ? nullptr : &image_;
}

}  // namespace earpoint
