#pragma once

// The frames of a movie's picture, each with its time. Private to the module.

#include "ffmpeg.h"
#include "frame_image.h"
#include "stream_decoder.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <earpoint/image.h>
#include <earpoint/media/media.h>

namespace earpoint::ffmpeg {

struct TimedFrame {
  FramePtr frame;       // none: there is no such frame
  double time_s = 0.0;  // since the container's start
};

class FrameSequence {
 public:
  /// @throws InputError if the file does not open or has no picture stream
  explicit FrameSequence(const std::filesystem::path& path);

  /// The next frame, none at the end. Times never go back; a missing one is one frame period after
  /// the one before.
  /// @throws InputError naming stream and time if the data are damaged
  TimedFrame next();
  [[nodiscard]] Image image(const TimedFrame& frame);

  /// Goes to a key frame at or before the time (some containers: near it).
  /// @return false if the file cannot do that; the position is unknown then
  bool seek(double time_s);
  /// Goes back to the first frame.
  void rewind();
  /// The time of the last key frame not after the given time, if the container knows it.
  [[nodiscard]] std::optional<double> key_frame_before(double time_s) const;

  [[nodiscard]] const StreamInfo& info() const { return info_; }
  [[nodiscard]] std::string where() const { return container_->where(info_.index); }
  /// From t = 0 to the end of the last frame: stated by the container, else found by reading it.
  [[nodiscard]] double duration_s();
  /// Whether every frame so far came with a time; without, seeking gives no time.
  [[nodiscard]] bool has_timestamps() const { return has_timestamps_; }
  [[nodiscard]] std::int64_t frames_decoded() const { return frames_decoded_; }

 private:
  std::filesystem::path path_;
  std::unique_ptr<InputContainer> container_;
  std::unique_ptr<StreamDecoder> decoder_;
  StreamInfo info_;
  Orientation orientation_;
  ImageMaker maker_;
  bool has_timestamps_ = true;
  std::optional<double> last_time_s_;
  std::optional<double> duration_s_;
  std::int64_t frames_decoded_ = 0;
};

}  // namespace earpoint::ffmpeg
