#include "stream_decoder.h"

#include <algorithm>

#include <fmt/format.h>

#include <earpoint/core/parallel.h>
#include <earpoint/error.h>

namespace earpoint::ffmpeg {

StreamDecoder::StreamDecoder(InputContainer& container, int stream)
    : container_(container), stream_(stream), packet_(make_packet()) {
  const AVStream& source = container.stream(stream);
  const std::string where = container.where(stream);
  const AVCodec* codec = avcodec_find_decoder(source.codecpar->codec_id);
  if (codec == nullptr) {
    throw InputError(where, fmt::format("no decoder for its codec, {}",
                                        avcodec_get_name(source.codecpar->codec_id)));
  }
  codec_ = make_codec_context(codec);
  check(avcodec_parameters_to_context(codec_.get(), source.codecpar), where, "cannot be decoded");
  codec_->pkt_timebase = source.time_base;
  codec_->max_pixels = kMaxPixels;
  // More threads than this only hold more frames in memory.
  constexpr int kMaxThreads = 4;
  codec_->thread_count = source.codecpar->codec_type == AVMEDIA_TYPE_VIDEO
                             ? std::min(available_cores(), kMaxThreads)
                             : 1;
  listen_to_log();
  check(avcodec_open2(codec_.get(), codec, nullptr), where, "cannot be decoded");
  container.select(stream);
}

void StreamDecoder::throw_damaged(int error, std::optional<double> time_s) const {
  throw InputError(container_.where(stream_, time_s), "is damaged (" + reason(error) + ")",
                   kDamagedHint);
}

void StreamDecoder::feed() {
  av_packet_unref(packet_.get());
  const bool has_packet = container_.read(*packet_);
  if (has_packet) packet_time_s_ = container_.time_s(stream_, packet_->pts);
  is_draining_ = !has_packet;
  listen_to_log();
  const int error = avcodec_send_packet(codec_.get(), has_packet ? packet_.get() : nullptr);
  if (error < 0 && error != AVERROR_EOF) throw_damaged(error, packet_time_s_);
}

bool StreamDecoder::next(AVFrame& frame) {
  for (;;) {
    listen_to_log();
    const int error = avcodec_receive_frame(codec_.get(), &frame);
    if (error == 0) break;
    if (error == AVERROR_EOF) return false;
    if (error != AVERROR(EAGAIN)) throw_damaged(error, packet_time_s_);
    if (is_draining_) return false;
    feed();
  }
  // Decoders conceal errors. A missing reference alone is no error: a recording may begin so.
  constexpr int kPatched = FF_DECODE_ERROR_INVALID_BITSTREAM | FF_DECODE_ERROR_DECODE_SLICES |
                           FF_DECODE_ERROR_CONCEALMENT_ACTIVE;
  if ((frame.decode_error_flags & kPatched) || (frame.flags & AV_FRAME_FLAG_CORRUPT)) {
    throw_damaged(AVERROR_INVALIDDATA, container_.time_s(stream_, frame.best_effort_timestamp));
  }
  return true;
}

bool StreamDecoder::seek(std::int64_t timestamp) {
  if (!container_.seek(stream_, timestamp)) return false;
  avcodec_flush_buffers(codec_.get());
  is_draining_ = false;
  return true;
}

}  // namespace earpoint::ffmpeg
