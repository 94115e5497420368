#pragma once

// What every file of this module needs to speak to FFmpeg: owners for its objects, its log kept
// off the terminal, and its errors as ours. Private to the module.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/avutil.h>
#include <libswscale/swscale.h>
}

namespace earpoint::ffmpeg {

struct PacketDeleter {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
struct FrameDeleter {
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
struct CodecContextDeleter {
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
};
struct ScalerDeleter {
  void operator()(SwsContext* context) const { sws_freeContext(context); }
};
using PacketPtr = std::unique_ptr<AVPacket, PacketDeleter>;
using FramePtr = std::unique_ptr<AVFrame, FrameDeleter>;
using CodecContextPtr = std::unique_ptr<AVCodecContext, CodecContextDeleter>;
using ScalerPtr = std::unique_ptr<SwsContext, ScalerDeleter>;

/// @throws std::bad_alloc
PacketPtr make_packet();
FramePtr make_frame();
CodecContextPtr make_codec_context(const AVCodec* codec);

/// Takes FFmpeg's log off the terminal, for the whole process, and forgets what this thread has
/// heard so far. Called wherever an operation begins.
void listen_to_log();

/// What FFmpeg first complained about in this thread since listen_to_log(); empty if it did not.
std::string first_complaint();

/// The complaint if there is one, else the meaning of the error number.
std::string reason(int error);

/// @throws InputError(where, "<problem> (<reason>)", hint) if error is negative
void check(int error, std::string_view where, std::string_view problem, std::string_view hint = {});

/// @throws std::bad_alloc if error is negative: for calls that fail only if memory runs out
void check_memory(int error);

/// Pictures larger than this are refused, so that a damaged header cannot ask for all memory.
constexpr std::int64_t kMaxPixels = 100'000'000;

/// What to say where data turn out damaged.
constexpr std::string_view kDamagedHint = "copy, export or record it again";

}  // namespace earpoint::ffmpeg
