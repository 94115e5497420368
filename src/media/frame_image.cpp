#include "frame_image.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <new>
#include <vector>

#include <earpoint/error.h>

extern "C" {
#include <libavutil/imgutils.h>
#include <libavutil/pixdesc.h>
}

namespace earpoint::ffmpeg {
namespace {

std::uint8_t rounded_quotient(unsigned value, unsigned divisor) {
  return static_cast<std::uint8_t>((value + divisor / 2) / divisor);
}

/// One component of one row as 0..255.
void read_component(const AVFrame& frame, const AVPixFmtDescriptor& format, int component, int y,
                    std::vector<std::uint16_t>& row) {
  std::array<const std::uint8_t*, 4> planes{};
  std::array<int, 4> strides{};
  for (std::size_t i = 0; i < planes.size(); ++i) {
    planes[i] = frame.data[i];
    strides[i] = frame.linesize[i];
  }
  av_read_image_line2(row.data(), planes.data(), strides.data(), &format, 0, y, component,
                      frame.width, /*read_pal_component=*/0, /*dst_element_size=*/2);
  const unsigned full = (1U << format.comp[component].depth) - 1;
  if (full == 255) return;
  for (std::uint16_t& value : row) value = rounded_quotient(value * 255U, full);
}

void expand_video_range(std::vector<std::uint16_t>& row) {
  for (std::uint16_t& value : row) {
    const int level = std::clamp<int>(value, 16, 235) - 16;
    value = rounded_quotient(static_cast<unsigned>(level) * 255U, 219U);
  }
}

Image image_from_palette(const AVFrame& frame) {
  Image image(frame.width, frame.height, 3);
  for (int y = 0; y < frame.height; ++y) {
    const std::uint8_t* row = frame.data[0] + std::ptrdiff_t{y} * frame.linesize[0];
    for (int x = 0; x < frame.width; ++x) {
      std::uint32_t argb = 0;
      std::memcpy(&argb, frame.data[1] + 4 * std::size_t{row[x]}, 4);
      const unsigned alpha = argb >> 24;
      for (int c = 0; c < 3; ++c) {
        image.at(x, y, c) = rounded_quotient((argb >> (16 - 8 * c) & 0xff) * alpha, 255);
      }
    }
  }
  return image;
}

bool is_exact(const AVPixFmtDescriptor& format, int pixel_format) {
  if (format.flags & (AV_PIX_FMT_FLAG_FLOAT | AV_PIX_FMT_FLAG_BAYER | AV_PIX_FMT_FLAG_HWACCEL)) {
    return false;
  }
  if (pixel_format == AV_PIX_FMT_MONOWHITE) return false;
  return (format.flags & AV_PIX_FMT_FLAG_RGB) || format.nb_components <= 2;
}

/// RGB, RGBA, grey, grey with alpha, of any depth up to 16.
Image image_from_components(const AVFrame& frame, const AVPixFmtDescriptor& format) {
  Image image(frame.width, frame.height, 3);
  const bool is_grey = format.nb_components <= 2;
  const bool has_alpha = format.flags & AV_PIX_FMT_FLAG_ALPHA;
  std::vector<std::uint16_t> row(static_cast<std::size_t>(frame.width));
  std::vector<std::uint16_t> alpha(row.size(), 255);
  for (int y = 0; y < frame.height; ++y) {
    if (has_alpha) read_component(frame, format, format.nb_components - 1, y, alpha);
    for (int c = 0; c < 3; ++c) {
      if (c == 0 || !is_grey) {
        read_component(frame, format, c, y, row);
        if (is_grey && frame.color_range == AVCOL_RANGE_MPEG) expand_video_range(row);
      }
      for (int x = 0; x < frame.width; ++x) {
        const auto i = static_cast<std::size_t>(x);
        image.at(x, y, c) = rounded_quotient(unsigned{row[i]} * alpha[i], 255);
      }
    }
  }
  return image;
}

int matrix_of(const AVFrame& frame) {
  switch (frame.colorspace) {
    case AVCOL_SPC_BT709:
      return SWS_CS_ITU709;
    case AVCOL_SPC_FCC:
      return SWS_CS_FCC;
    case AVCOL_SPC_SMPTE240M:
      return SWS_CS_SMPTE240M;
    case AVCOL_SPC_BT2020_NCL:
    case AVCOL_SPC_BT2020_CL:
      return SWS_CS_BT2020;
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M:
      return SWS_CS_ITU601;
    default:
      return frame.height >= 720 && frame.color_range != AVCOL_RANGE_JPEG ? SWS_CS_ITU709
                                                                          : SWS_CS_ITU601;
  }
}

/// FFmpeg's old names for full-range formats; its scaler warns about them.
AVPixelFormat without_range(AVPixelFormat format) {
  switch (format) {
    case AV_PIX_FMT_YUVJ420P:
      return AV_PIX_FMT_YUV420P;
    case AV_PIX_FMT_YUVJ411P:
      return AV_PIX_FMT_YUV411P;
    case AV_PIX_FMT_YUVJ422P:
      return AV_PIX_FMT_YUV422P;
    case AV_PIX_FMT_YUVJ444P:
      return AV_PIX_FMT_YUV444P;
    case AV_PIX_FMT_YUVJ440P:
      return AV_PIX_FMT_YUV440P;
    default:
      return format;
  }
}

constexpr int kScalerFlags =
    SWS_BICUBIC | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP | SWS_ACCURATE_RND | SWS_BITEXACT;

FramePtr make_picture_frame(AVPixelFormat format, int width, int height) {
  FramePtr frame = make_frame();
  frame->format = format;
  frame->width = width;
  frame->height = height;
  check_memory(av_frame_get_buffer(frame.get(), 0));
  return frame;
}

/// The image's pixels in a frame of the same kind, its edges repeated to the right and below.
FramePtr frame_of_pixels(const Image& image, int width, int height) {
  const bool is_grey = image.channels() == 1;
  FramePtr frame = make_picture_frame(is_grey ? AV_PIX_FMT_GRAY8 : AV_PIX_FMT_RGB24, width, height);
  const auto pixel_bytes = static_cast<std::size_t>(image.channels());
  const std::size_t row_bytes = static_cast<std::size_t>(image.width()) * pixel_bytes;
  for (int y = 0; y < height; ++y) {
    const auto source_y = static_cast<std::size_t>(std::min(y, image.height() - 1));
    std::uint8_t* row = frame->data[0] + std::ptrdiff_t{y} * frame->linesize[0];
    std::memcpy(row, image.pixels().data() + source_y * row_bytes, row_bytes);
    for (int x = image.width(); x < width; ++x) {
      std::uint8_t* pixel = row + static_cast<std::size_t>(x) * pixel_bytes;
      std::memcpy(pixel, pixel - pixel_bytes, pixel_bytes);
    }
  }
  return frame;
}

}  // namespace

Orientation orientation_from_display_matrix(const std::int32_t* matrix) {
  // x' = m0 x + m3 y, y' = m1 x + m4 y. The larger entry of the first column decides the turn.
  const std::int64_t xx = matrix[0];
  const std::int64_t xy = matrix[3];
  const std::int64_t yx = matrix[1];
  const std::int64_t yy = matrix[4];
  const bool is_mirrored = xx * yy - xy * yx < 0;
  const int mirror = is_mirrored ? -1 : 1;
  if (std::abs(xx) >= std::abs(yx)) {
    const int sign = xx < 0 ? -1 : 1;
    return {sign, 0, 0, sign * mirror};
  }
  const int sign = yx < 0 ? -1 : 1;
  return {0, -sign * mirror, sign, 0};
}

Orientation orientation_from_exif(int exif) {
  switch (exif) {
    case 2:
      return {-1, 0, 0, 1};
    case 3:
      return {-1, 0, 0, -1};
    case 4:
      return {1, 0, 0, -1};
    case 5:
      return {0, 1, 1, 0};
    case 6:
      return {0, -1, 1, 0};
    case 7:
      return {0, -1, -1, 0};
    case 8:
      return {0, 1, -1, 0};
    default:
      return {};
  }
}

int rotation_deg(const Orientation& orientation) {
  // The source's upward direction gives the rotation, mirrored or not.
  if (orientation.yy == 1) return 0;
  if (orientation.yy == -1) return 180;
  return orientation.xy == -1 ? 90 : 270;
}

Image oriented(const Image& image, const Orientation& o) {
  if (o == Orientation{}) return image;
  const bool is_transposed = o.xx == 0;
  const int width = is_transposed ? image.height() : image.width();
  const int height = is_transposed ? image.width() : image.height();
  Image turned(width, height, image.channels());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      // The inverse of a quarter turn is its transpose; a negative sign counts from the far edge.
      const int source_x =
          is_transposed ? (o.yx > 0 ? y : height - 1 - y) : (o.xx > 0 ? x : width - 1 - x);
      const int source_y =
          is_transposed ? (o.xy > 0 ? x : width - 1 - x) : (o.yy > 0 ? y : height - 1 - y);
      for (int c = 0; c < image.channels(); ++c) {
        turned.at(x, y, c) = image.at(source_x, source_y, c);
      }
    }
  }
  return turned;
}

Image ImageMaker::image(const AVFrame& frame, std::string_view where) {
  const AVPixFmtDescriptor* format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  if (format == nullptr || frame.width <= 0 || frame.height <= 0) {
    throw InputError(where, "has no picture", kDamagedHint);
  }
  if (frame.format == AV_PIX_FMT_PAL8) return image_from_palette(frame);
  if (is_exact(*format, frame.format)) return image_from_components(frame, *format);

  const auto source_format = without_range(static_cast<AVPixelFormat>(frame.format));
  const bool is_full_range = frame.color_range == AVCOL_RANGE_JPEG || source_format != frame.format;
  scaler_.reset(sws_getCachedContext(scaler_.release(), frame.width, frame.height, source_format,
                                     frame.width, frame.height, AV_PIX_FMT_RGB24, kScalerFlags,
                                     nullptr, nullptr, nullptr));
  if (!scaler_)
    throw InputError(where, std::string("has pixels of an unknown kind, ") + format->name);
  const int* matrix = sws_getCoefficients(matrix_of(frame));
  sws_setColorspaceDetails(scaler_.get(), matrix, is_full_range ? 1 : 0, matrix, 1, 0, 1 << 16,
                           1 << 16);
  // The scaler writes whole vectors, past the end of a row: it needs a frame with room for that.
  const FramePtr rgb = make_picture_frame(AV_PIX_FMT_RGB24, frame.width, frame.height);
  check(sws_scale(scaler_.get(), frame.data, frame.linesize, 0, frame.height, rgb->data,
                  rgb->linesize),
        where, "cannot be converted to RGB");
  Image image(frame.width, frame.height, 3);
  const std::size_t row_bytes = static_cast<std::size_t>(frame.width) * 3;
  for (int y = 0; y < frame.height; ++y) {
    std::memcpy(image.pixels().data() + static_cast<std::size_t>(y) * row_bytes,
                rgb->data[0] + std::ptrdiff_t{y} * rgb->linesize[0], row_bytes);
  }
  return image;
}

FramePtr frame_from_image(const Image& image, AVPixelFormat format, int width, int height,
                          AVColorSpace space, AVColorRange range) {
  EARPOINT_CHECK(!image.empty() && (image.channels() == 1 || image.channels() == 3));
  EARPOINT_CHECK(width >= image.width() && height >= image.height());
  FramePtr pixels = frame_of_pixels(image, width, height);
  if (pixels->format == format) return pixels;

  FramePtr frame = make_picture_frame(format, width, height);
  frame->colorspace = space;
  frame->color_range = range;
  const ScalerPtr scaler(sws_getContext(width, height, static_cast<AVPixelFormat>(pixels->format),
                                        width, height, without_range(format), kScalerFlags, nullptr,
                                        nullptr, nullptr));
  if (!scaler) throw std::bad_alloc();
  const int* matrix = sws_getCoefficients(space == AVCOL_SPC_BT709 ? SWS_CS_ITU709 : SWS_CS_ITU601);
  sws_setColorspaceDetails(scaler.get(), matrix, 1, matrix, range == AVCOL_RANGE_JPEG ? 1 : 0, 0,
                           1 << 16, 1 << 16);
  check_memory(sws_scale(scaler.get(), pixels->data, pixels->linesize, 0, height, frame->data,
                         frame->linesize));
  return frame;
}

}  // namespace earpoint::ffmpeg
