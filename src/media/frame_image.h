#pragma once

// FFmpeg frames to pictures and back. Private to the module.

#include "ffmpeg.h"

#include <cstdint>
#include <string_view>

#include <earpoint/image.h>

namespace earpoint::ffmpeg {

/// A turn by quarters, with or without a mirror: the position (x right, y down, from the picture's
/// middle) becomes (xx x + xy y, yx x + yy y). Entries are -1, 0 or 1.
struct Orientation {
  int xx = 1;
  int xy = 0;
  int yx = 0;
  int yy = 1;

  friend constexpr bool operator==(const Orientation&, const Orientation&) = default;
};

/// The nearest quarter turn to a display matrix (nine 16.16 numbers, as FFmpeg stores it).
Orientation orientation_from_display_matrix(const std::int32_t* matrix);

/// @param exif  1..8; anything else is upright
Orientation orientation_from_exif(int exif);

/// @return  clockwise, 0, 90, 180 or 270; a mirror is not told
int rotation_deg(const Orientation& orientation);

[[nodiscard]] Image oriented(const Image& image, const Orientation& orientation);

/// Turns frames into RGB pictures. RGB, grey and palette frames exactly (other depths scaled and
/// rounded, transparency composited on black); YCbCr by the matrix and range that the frame states;
/// if it states none, BT.709 from 720 lines on and BT.601 below, as players do.
class ImageMaker {
 public:
  /// @throws InputError(where, ...) if FFmpeg cannot convert the frame's pixel format
  [[nodiscard]] Image image(const AVFrame& frame, std::string_view where);

 private:
  ScalerPtr scaler_;  // kept from frame to frame while the format stays
};

/// A frame of the given pixel format (RGB24, GRAY8, or YUV of 8 bits with BT.709 matrix) that shows
/// the image; edges are repeated if the frame is larger than the image.
/// @param format  with `range` for the YUV ones
[[nodiscard]] FramePtr frame_from_image(const Image& image, AVPixelFormat format, int width,
                                        int height, AVColorSpace space, AVColorRange range);

}  // namespace earpoint::ffmpeg
