#pragma once

// Encoders for the streams of a movie. Private to the module.

#include "ffmpeg.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <earpoint/core/parallel.h>
#include <earpoint/image.h>
#include <earpoint/waveform.h>

namespace earpoint::ffmpeg {

/// What an encoder does with each packet that is ready.
using PacketSink = FunctionRef<void(AVPacket&)>;

/// Stereo AAC. Packets' times are in samples; sample 0 is at 0, the encoder's delay before it.
class SoundEncoder {
 public:
  /// @param where  names the file in messages
  /// @throws InputError if AAC does not know the rate
  SoundEncoder(std::string where, int sample_rate_hz);

  [[nodiscard]] const AVCodecContext& codec() const { return *codec_; }
  [[nodiscard]] std::int64_t samples() const { return samples_; }

  /// @throws InputError if a sample is not finite
  void encode(const Waveform& block, PacketSink sink);
  void flush(PacketSink sink);

 private:
  void encode_pending(int samples, PacketSink sink);
  void drain(PacketSink sink);

  std::string where_;
  CodecContextPtr codec_;
  PacketPtr packet_;
  std::array<std::vector<float>, 2> pending_;  // less than a frame of the codec, between calls
  std::int64_t samples_ = 0;                   // given to the codec
};

/// H.264 from RGB pictures. Packets' times are in the time base given.
class PictureEncoder {
 public:
  /// @throws InputError if FFmpeg has no H.264 encoder
  PictureEncoder(std::string where, int width, int height, AVRational frame_rate,
                 AVRational time_base);

  [[nodiscard]] const AVCodecContext& codec() const { return *codec_; }

  /// @param timestamp  larger than the one before
  void encode(const Image& image, std::int64_t timestamp, PacketSink sink);
  void flush(PacketSink sink);

 private:
  void drain(PacketSink sink);

  std::string where_;
  CodecContextPtr codec_;
  PacketPtr packet_;
  std::int64_t frame_duration_ = 1;
};

}  // namespace earpoint::ffmpeg
