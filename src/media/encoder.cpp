#include "encoder.h"

#include "frame_image.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <earpoint/error.h>

extern "C" {
#include <libavutil/channel_layout.h>
#include <libavutil/opt.h>
}

namespace earpoint::ffmpeg {
namespace {

constexpr std::int64_t kSoundBitRate = 192'000;
// Constant quality on x264's scale: 0 is lossless, 23 its default, 18 hard to tell from the source.
constexpr const char* kPictureQuality = "18";
constexpr const char* kPicturePreset = "faster";

void receive(AVCodecContext& codec, AVPacket& packet, const std::string& where, const char* what,
             PacketSink sink) {
  for (;;) {
    const int error = avcodec_receive_packet(&codec, &packet);
    if (error == AVERROR(EAGAIN) || error == AVERROR_EOF) return;
    check(error, where, fmt::format("the {} cannot be encoded", what));
    sink(packet);
    av_packet_unref(&packet);
  }
}

bool knows_rate(const AVCodec& codec, int sample_rate_hz) {
  for (const int* rate = codec.supported_samplerates; rate != nullptr && *rate != 0; ++rate) {
    if (*rate == sample_rate_hz) return true;
  }
  return false;
}

int even(int size) { return size + size % 2; }

}  // namespace

SoundEncoder::SoundEncoder(std::string where, int sample_rate_hz)
    : where_(std::move(where)), packet_(make_packet()) {
  EARPOINT_CHECK(sample_rate_hz > 0);
  const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_AAC);
  if (codec == nullptr) throw InputError(where_, "this FFmpeg has no AAC encoder");
  if (!knows_rate(*codec, sample_rate_hz)) {
    throw InputError(where_, fmt::format("AAC sound cannot have {} Hz", sample_rate_hz),
                     "write a .wav file, or resample to 48000 Hz");
  }
  codec_ = make_codec_context(codec);
  codec_->sample_fmt = AV_SAMPLE_FMT_FLTP;
  codec_->sample_rate = sample_rate_hz;
  codec_->time_base = {1, sample_rate_hz};
  codec_->bit_rate = std::min(kSoundBitRate, std::int64_t{8} * sample_rate_hz);
  codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
  av_channel_layout_default(&codec_->ch_layout, 2);
  listen_to_log();
  check(avcodec_open2(codec_.get(), codec, nullptr), where_, "the sound cannot be encoded");
}

void SoundEncoder::encode(const Waveform& block, PacketSink sink) {
  EARPOINT_CHECK(block.channels() == 2 && block.sample_rate_hz() == codec_->sample_rate);
  const auto frame_size = static_cast<std::size_t>(codec_->frame_size);
  std::size_t taken = 0;
  const auto count = static_cast<std::size_t>(block.samples());
  while (taken < count) {
    const std::size_t part = std::min(count - taken, frame_size - pending_[0].size());
    for (int ear = 0; ear < 2; ++ear) {
      const auto from = block.channel(ear).subspan(taken, part);
      pending_[static_cast<std::size_t>(ear)].insert(pending_[static_cast<std::size_t>(ear)].end(),
                                                     from.begin(), from.end());
    }
    taken += part;
    if (pending_[0].size() == frame_size) encode_pending(codec_->frame_size, sink);
  }
}

void SoundEncoder::encode_pending(int samples, PacketSink sink) {
  const FramePtr frame = make_frame();
  frame->format = codec_->sample_fmt;
  frame->nb_samples = samples;
  frame->sample_rate = codec_->sample_rate;
  frame->pts = samples_;
  check_memory(av_channel_layout_copy(&frame->ch_layout, &codec_->ch_layout));
  check_memory(av_frame_get_buffer(frame.get(), 0));
  for (std::size_t ear = 0; ear < 2; ++ear) {
    std::copy(pending_[ear].begin(), pending_[ear].end(),
              reinterpret_cast<float*>(frame->extended_data[ear]));
    pending_[ear].clear();
  }
  samples_ += samples;
  listen_to_log();
  check(avcodec_send_frame(codec_.get(), frame.get()), where_, "the sound cannot be encoded");
  drain(sink);
}

void SoundEncoder::drain(PacketSink sink) { receive(*codec_, *packet_, where_, "sound", sink); }

void SoundEncoder::flush(PacketSink sink) {
  if (!pending_[0].empty()) encode_pending(static_cast<int>(pending_[0].size()), sink);
  listen_to_log();
  check(avcodec_send_frame(codec_.get(), nullptr), where_, "the sound cannot be encoded");
  drain(sink);
}

PictureEncoder::PictureEncoder(std::string where, int width, int height, AVRational frame_rate,
                               AVRational time_base)
    : where_(std::move(where)), packet_(make_packet()) {
  const AVCodec* codec = avcodec_find_encoder_by_name("libx264");
  if (codec == nullptr) codec = avcodec_find_encoder(AV_CODEC_ID_H264);
  if (codec == nullptr) {
    throw InputError(where_, "this FFmpeg has no H.264 encoder", "install one with libx264");
  }
  codec_ = make_codec_context(codec);
  codec_->width = even(width);
  codec_->height = even(height);
  codec_->pix_fmt = AV_PIX_FMT_YUV420P;
  codec_->time_base = time_base;
  codec_->framerate = frame_rate;
  codec_->colorspace = AVCOL_SPC_BT709;
  codec_->color_primaries = AVCOL_PRI_BT709;
  codec_->color_trc = AVCOL_TRC_BT709;
  codec_->color_range = AVCOL_RANGE_MPEG;
  codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  // The same pictures must give the same bytes everywhere: by default x264 takes as many threads as
  // there are cores, and its macroblock tree reads uninitialized memory.
  codec_->thread_count = 1;
  av_opt_set(codec_->priv_data, "mbtree", "0", 0);
  av_opt_set(codec_->priv_data, "preset", kPicturePreset, 0);
  av_opt_set(codec_->priv_data, "crf", kPictureQuality, 0);
  frame_duration_ = std::max<std::int64_t>(1, av_rescale_q(1, av_inv_q(frame_rate), time_base));
  listen_to_log();
  check(avcodec_open2(codec_.get(), codec, nullptr), where_, "the picture cannot be encoded");
}

void PictureEncoder::encode(const Image& image, std::int64_t timestamp, PacketSink sink) {
  EARPOINT_CHECK(image.channels() == 3);
  EARPOINT_CHECK(even(image.width()) == codec_->width && even(image.height()) == codec_->height);
  const FramePtr frame = frame_from_image(image, codec_->pix_fmt, codec_->width, codec_->height,
                                          codec_->colorspace, codec_->color_range);
  frame->pts = timestamp;
  listen_to_log();
  check(avcodec_send_frame(codec_.get(), frame.get()), where_, "the picture cannot be encoded");
  drain(sink);
}

void PictureEncoder::drain(PacketSink sink) {
  const auto with_duration = [&](AVPacket& packet) {
    packet.duration = frame_duration_;
    sink(packet);
  };
  receive(*codec_, *packet_, where_, "picture", with_duration);
}

void PictureEncoder::flush(PacketSink sink) {
  listen_to_log();
  check(avcodec_send_frame(codec_.get(), nullptr), where_, "the picture cannot be encoded");
  drain(sink);
}

}  // namespace earpoint::ffmpeg
