#include <earpoint/media/image_file.h>

#include "exif.h"
#include "ffmpeg.h"
#include "frame_image.h"
#include "picture.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include <fmt/format.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>

extern "C" {
#include <libavutil/opt.h>
}

namespace earpoint {
namespace {

using namespace ffmpeg;  // NOLINT(google-build-using-namespace): our own, private

constexpr std::array<std::uint8_t, 8> kPngSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
constexpr std::array<std::uint8_t, 3> kJpegSignature = {0xff, 0xd8, 0xff};

template <std::size_t size>
bool begins_with(std::span<const std::byte> bytes,
                 const std::array<std::uint8_t, size>& signature) {
  return bytes.size() >= size && std::memcmp(bytes.data(), signature.data(), size) == 0;
}

PacketPtr packet_of(std::span<const std::byte> bytes) {
  PacketPtr packet = make_packet();
  check_memory(av_new_packet(packet.get(), static_cast<int>(bytes.size())));
  std::memcpy(packet->data, bytes.data(), bytes.size());
  return packet;
}

/// Whether the last scan of a JPEG file comes to its end marker: the decoder does not mind if a few
/// rows are missing. Neither marker occurs within coded data.
bool ends_properly(std::span<const std::byte> jpeg) {
  for (std::size_t i = jpeg.size() - 1; i > 0; --i) {
    if (jpeg[i - 1] != std::byte{0xff}) continue;
    if (jpeg[i] == std::byte{0xd9}) return true;
    if (jpeg[i] == std::byte{0xda}) return false;
  }
  return false;
}

FramePtr decode_picture(std::span<const std::byte> bytes, AVCodecID id, const std::string& where) {
  CodecContextPtr codec = make_codec_context(avcodec_find_decoder(id));
  codec->max_pixels = kMaxPixels;
  codec->thread_count = 1;
  codec->err_recognition = AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER | AV_EF_EXPLODE;
  listen_to_log();
  check(avcodec_open2(codec.get(), codec->codec, nullptr), where, "cannot be decoded");

  const PacketPtr packet = packet_of(bytes);
  constexpr const char* kProblem = "is damaged, cut short or too large";
  FramePtr frame = make_frame();
  check(avcodec_send_packet(codec.get(), packet.get()), where, kProblem, kDamagedHint);
  check(avcodec_send_packet(codec.get(), nullptr), where, kProblem, kDamagedHint);
  check(avcodec_receive_frame(codec.get(), frame.get()), where, kProblem, kDamagedHint);
  // Decoders return part of a picture with an error message; that is refused.
  if (!first_complaint().empty() || frame->decode_error_flags != 0 ||
      (frame->flags & AV_FRAME_FLAG_CORRUPT)) {
    check(AVERROR_INVALIDDATA, where, kProblem, kDamagedHint);
  }
  return frame;
}

/// What the extension asks for.
AVCodecID codec_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".jpg" || extension == ".jpeg") return AV_CODEC_ID_MJPEG;
  if (extension == ".png") return AV_CODEC_ID_PNG;
  throw InputError(path.string(),
                   fmt::format("pictures are written as .png, .jpg or .jpeg, not '{}'", extension));
}

/// The whole picture as the bytes of a file.
PacketPtr encode_picture(const Image& image, AVCodecID id) {
  const bool is_jpeg = id == AV_CODEC_ID_MJPEG;
  const AVPixelFormat format = is_jpeg                 ? AV_PIX_FMT_YUVJ444P
                               : image.channels() == 1 ? AV_PIX_FMT_GRAY8
                                                       : AV_PIX_FMT_RGB24;
  CodecContextPtr codec = make_codec_context(avcodec_find_encoder(id));
  codec->width = image.width();
  codec->height = image.height();
  codec->pix_fmt = format;
  codec->time_base = {1, 25};
  codec->thread_count = 1;
  codec->flags |= AV_CODEC_FLAG_BITEXACT;
  if (is_jpeg) {
    constexpr int kJpegQuantiser = 2;  // FFmpeg's scale, 1 (best) to 31
    codec->color_range = AVCOL_RANGE_JPEG;
    codec->flags |= AV_CODEC_FLAG_QSCALE;
    codec->global_quality = FF_QP2LAMBDA * kJpegQuantiser;
  } else {
    av_opt_set(codec->priv_data, "pred", "mixed", 0);
  }
  check_memory(avcodec_open2(codec.get(), codec->codec, nullptr));

  const FramePtr frame = frame_from_image(image, format, image.width(), image.height(),
                                          AVCOL_SPC_BT470BG, AVCOL_RANGE_JPEG);
  frame->quality = codec->global_quality;
  frame->pts = 0;
  PacketPtr packet = make_packet();
  check_memory(avcodec_send_frame(codec.get(), frame.get()));
  check_memory(avcodec_send_frame(codec.get(), nullptr));
  check_memory(avcodec_receive_packet(codec.get(), packet.get()));
  return packet;
}

}  // namespace

std::optional<PictureFormat> picture_format(std::span<const std::byte> bytes) {
  if (begins_with(bytes, kPngSignature)) return PictureFormat::png;
  if (begins_with(bytes, kJpegSignature)) return PictureFormat::jpeg;
  return std::nullopt;
}

std::optional<std::string_view> other_picture(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.size() >= 12 && text.substr(4, 4) == "ftyp") {
    const std::string_view brand = text.substr(8, 4);
    for (const char* heif : {"heic", "heix", "heim", "heis", "hevc", "hevx", "mif1", "msf1"}) {
      if (brand == heif) return "HEIC";
    }
    if (brand == "avif" || brand == "avis") return "AVIF";
  }
  if (text.starts_with("RIFF") && text.size() >= 12 && text.substr(8, 4) == "WEBP") return "WebP";
  if (text.starts_with("GIF8")) return "GIF";
  if (text.starts_with(std::string_view("II*\0", 4)) ||
      text.starts_with(std::string_view("MM\0*", 4))) {
    return "TIFF or raw";
  }
  if (text.size() >= 14 && text.starts_with("BM") &&
      text.substr(6, 4) == std::string_view("\0\0\0\0", 4)) {
    return "BMP";
  }
  return std::nullopt;
}

void refuse_other_picture(std::span<const std::byte> bytes, const std::string& name) {
  const auto kind = other_picture(bytes);
  if (!kind) return;
  throw InputError(name, fmt::format("is a {} picture; PNG and JPEG are read", *kind),
                   "convert it to one of them");
}

Image decode_image(std::span<const std::byte> bytes, std::string_view name) {
  const std::string where(name);
  if (bytes.empty()) throw InputError(where, "is empty");
  const auto format = picture_format(bytes);
  if (!format) refuse_other_picture(bytes, where);
  if (!format) throw InputError(where, "is neither a PNG nor a JPEG picture");

  const bool is_jpeg = *format == PictureFormat::jpeg;
  if (is_jpeg && !ends_properly(bytes)) {
    throw InputError(where, "is truncated (no end marker)", kDamagedHint);
  }
  const FramePtr frame =
      decode_picture(bytes, is_jpeg ? AV_CODEC_ID_MJPEG : AV_CODEC_ID_PNG, where);
  ImageMaker maker;
  const Orientation orientation = orientation_from_exif(read_exif(bytes).orientation);
  return oriented(maker.image(*frame, where), orientation);
}

Image read_image(const std::filesystem::path& path) {
  return decode_image(read_file(path), path.string());
}

namespace {

std::vector<std::byte> encode(const Image& image, AVCodecID codec) {
  EARPOINT_CHECK(!image.empty() && (image.channels() == 1 || image.channels() == 3));
  listen_to_log();
  const PacketPtr packet = encode_picture(image, codec);
  const auto bytes = std::as_bytes(std::span(packet->data, static_cast<std::size_t>(packet->size)));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

std::vector<std::byte> encode_png(const Image& image) { return encode(image, AV_CODEC_ID_PNG); }

std::vector<std::byte> encode_jpeg(const Image& image) { return encode(image, AV_CODEC_ID_MJPEG); }

void check_image_path(const std::filesystem::path& path) {
  (void)codec_of(path);
  const AtomicFile probe(path);
}

void write_image(const std::filesystem::path& path, const Image& image) {
  write_file(path, encode(image, codec_of(path)));
}

}  // namespace earpoint
