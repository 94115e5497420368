#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include <earpoint/image.h>
#include <earpoint/media/media.h>

namespace earpoint {

/// The pictures of a clip: a still one, a movie's frames, or none.
class PictureStream {
 public:
  /// No picture.
  PictureStream() = default;
  /// @throws InputError if the file is neither a picture nor a movie with frames
  explicit PictureStream(const std::filesystem::path& path);

  /// A still picture in memory; null: none.
  explicit PictureStream(std::shared_ptr<const Image> picture) : image_(std::move(picture)) {}

  [[nodiscard]] bool empty() const { return !frames_ && image_ == nullptr; }

  /// @return the frame nearest to that time; null if there is none
  [[nodiscard]] std::shared_ptr<const Image> nearest(double time_s);

 private:
  std::optional<FrameReader> frames_;
  std::shared_ptr<const Image> image_;
};

/// The pictures that go with a sound: those of `picture`, or else of the sound's own movie, or
/// none.
/// @throws InputError if `picture` is neither a picture nor a movie with frames
PictureStream open_pictures(const std::optional<std::filesystem::path>& picture,
                            const std::filesystem::path& sound);

}  // namespace earpoint
