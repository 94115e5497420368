#pragma once

// A decoder for one stream of an opened movie or sound file. Private to the module.

#include "container.h"
#include "ffmpeg.h"

#include <cstdint>
#include <optional>

namespace earpoint::ffmpeg {

/// Decodes one stream of a container, frame by frame in order of presentation.
class StreamDecoder {
 public:
  /// @throws InputError if there is no decoder for it
  StreamDecoder(InputContainer& container, int stream);

  /// @return false at the end
  /// @throws InputError naming stream and time if the data are damaged
  bool next(AVFrame& frame);
  /// As InputContainer::seek; the next frame is the first that can be decoded from there.
  bool seek(std::int64_t timestamp);

 private:
  void feed();
  [[noreturn]] void throw_damaged(int error, std::optional<double> time_s) const;

  InputContainer& container_;
  int stream_;
  CodecContextPtr codec_;
  PacketPtr packet_;
  bool is_draining_ = false;
  std::optional<double> packet_time_s_;
};

}  // namespace earpoint::ffmpeg
