#include "picture_writer.h"

#include "container.h"
#include "encoder.h"
#include "frame_sequence.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include <earpoint/error.h>

namespace earpoint::ffmpeg {
namespace {

/// A movie needs a picture.
[[noreturn]] void refuse_empty(const std::string& where) {
  throw InputError(where, "has no picture that can be decoded", "record or export it again");
}

/// Another movie's packets, as they are.
class CopiedPictures : public PictureWriter {
 public:
  CopiedPictures(std::unique_ptr<InputContainer> source, int index, OutputContainer& output)
      : source_(std::move(source)),
        index_(index),
        output_(output),
        stream_(add_stream()),
        packet_(make_packet()) {
    source_->select(index_);
    has_packet_ = source_->read(*packet_);
    if (!has_packet_) refuse_empty(source_->where(index_));
  }

  void write_until(double time_s) override {
    const AVRational tick = source_->stream(index_).time_base;
    while (has_packet_) {
      const std::int64_t stamp = packet_->dts != AV_NOPTS_VALUE ? packet_->dts : packet_->pts;
      if (source_->time_s(index_, stamp).value_or(0.0) > time_s) return;
      retime();
      output_.write(*packet_, stream_, tick);
      has_packet_ = source_->read(*packet_);
    }
  }

  void finish() override { write_until(std::numeric_limits<double>::infinity()); }

 private:
  AVStream& add_stream() {
    const AVStream& input = source_->stream(index_);
    // The new file's header names the pixels' format; without it no player opens the file.
    if (input.codecpar->format == AV_PIX_FMT_NONE) refuse_empty(source_->where(index_));
    AVStream& stream = output_.add_stream(*input.codecpar, input.time_base);
    // The tag that every player knows for HEVC with out-of-band parameter sets, as here.
    const bool is_hevc =
        input.codecpar->codec_id == AV_CODEC_ID_HEVC && output_.format_name() != "matroska";
    stream.codecpar->codec_tag = is_hevc ? MKTAG('h', 'v', 'c', '1') : 0;
    stream.sample_aspect_ratio = input.sample_aspect_ratio;
    stream.avg_frame_rate = input.avg_frame_rate;
    for (int i = 0; i < input.nb_side_data; ++i) {
      const AVPacketSideData& data = input.side_data[i];
      std::uint8_t* copy = av_stream_new_side_data(&stream, data.type, data.size);
      if (copy == nullptr) throw std::bad_alloc();
      std::copy_n(data.data, data.size, copy);
    }
    return stream;
  }

  /// Makes times count from the container's start, complete and increasing, as files need them.
  void retime() {
    AVPacket& packet = *packet_;
    if (packet.dts == AV_NOPTS_VALUE) packet.dts = packet.pts;
    if (packet.pts == AV_NOPTS_VALUE) packet.pts = packet.dts;
    if (packet.dts == AV_NOPTS_VALUE) {
      throw InputError(source_->where(index_), "has pictures without a time",
                       "convert it to mp4 first");
    }
    const std::int64_t start = source_->timestamp(index_, 0.0);
    packet.dts -= start;
    packet.pts -= start;
    if (last_dts_ && packet.dts <= *last_dts_) packet.dts = *last_dts_ + 1;
    packet.pts = std::max(packet.pts, packet.dts);
    last_dts_ = packet.dts;
  }

  std::unique_ptr<InputContainer> source_;
  int index_;
  OutputContainer& output_;
  AVStream& stream_;
  PacketPtr packet_;  // the next to be written
  bool has_packet_ = false;
  std::optional<std::int64_t> last_dts_;
};

/// Another movie's frames, encoded anew, at their own times.
class EncodedPictures : public PictureWriter {
 public:
  EncodedPictures(const std::filesystem::path& source, OutputContainer& output)
      : output_(output),
        frames_(source),
        encoder_(output.path().string(), frames_.info().width, frames_.info().height,
                 frame_rate(frames_.info()), kTick),
        stream_(output.add_stream(encoder_.codec())),
        next_(frames_.next()) {
    if (!next_.frame) refuse_empty(source.string());
  }

  void write_until(double time_s) override {
    while (next_.frame && next_.time_s <= time_s) {
      const std::int64_t stamp = std::llround(next_.time_s / av_q2d(kTick));
      // Of two frames at one time the first is as good as the second.
      if (!last_stamp_ || stamp > *last_stamp_) {
        encoder_.encode(frames_.image(next_), stamp, [this](AVPacket& packet) { put(packet); });
        last_stamp_ = stamp;
      }
      next_ = frames_.next();
    }
  }

  void finish() override {
    write_until(std::numeric_limits<double>::infinity());
    encoder_.flush([this](AVPacket& packet) { put(packet); });
  }

 private:
  static constexpr AVRational kTick = {1, 90'000};  // the clock of broadcast video

  static AVRational frame_rate(const StreamInfo& info) {
    constexpr double kFallbackHz = 25.0;  // steers the encoder's rate control only
    return av_d2q(info.frame_rate_hz > 0.0 ? info.frame_rate_hz : kFallbackHz, 100'000);
  }

  void put(AVPacket& packet) { output_.write(packet, stream_, kTick); }

  OutputContainer& output_;
  FrameSequence frames_;
  PictureEncoder encoder_;
  AVStream& stream_;
  TimedFrame next_;
  std::optional<std::int64_t> last_stamp_;
};

/// Codecs that players expect in mp4, from containers that store them in the same form and know
/// the order of decoding.
bool is_copyable(const AVInputFormat& container, AVCodecID codec) {
  const bool has_same_form = std::strstr(container.name, "mp4") != nullptr ||
                             std::strstr(container.name, "matroska") != nullptr;
  switch (codec) {
    case AV_CODEC_ID_H264:
    case AV_CODEC_ID_HEVC:
    case AV_CODEC_ID_AV1:
    case AV_CODEC_ID_VP9:
    case AV_CODEC_ID_MPEG4:
      return has_same_form;
    default:
      return false;
  }
}

/// Matroska drops times before zero: what was recorded then has to be counted, which needs
/// decoding.
bool begins_with_a_time(const std::filesystem::path& source, int index) {
  InputContainer container(source);
  container.select(index);
  const PacketPtr packet = make_packet();
  return !container.read(*packet) || packet->pts != AV_NOPTS_VALUE || packet->dts != AV_NOPTS_VALUE;
}

}  // namespace

std::unique_ptr<PictureWriter> picture_of_movie(const std::filesystem::path& source,
                                                OutputContainer& output) {
  auto container = std::make_unique<InputContainer>(source);
  const int index = container->preferred_stream(StreamKind::video);
  const AVCodecID codec = container->stream(index).codecpar->codec_id;
  if (is_copyable(*container->format().iformat, codec) && begins_with_a_time(source, index)) {
    return std::make_unique<CopiedPictures>(std::move(container), index, output);
  }
  container.reset();
  return std::make_unique<EncodedPictures>(source, output);
}

}  // namespace earpoint::ffmpeg
