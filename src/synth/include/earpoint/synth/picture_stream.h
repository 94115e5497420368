#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include <earpoint/core/image.h>
#include <earpoint/video/media.h>

namespace earpoint {

/// The pictures of a clip: a still one, a movie's frames, or none.
class PictureStream {
 public:
  /// No picture.
  PictureStream() = default;
  /// @throws InputError if the file is neither a picture nor a movie with frames
  explicit PictureStream(const std::filesystem::path& path);

  /// @return the frame nearest to that time, valid until the next call; null if there is none
  [[nodiscard]] const Image* nearest(double time_s);

 private:
  std::optional<FrameReader> frames_;
  Image image_;
};

}  // namespace earpoint
