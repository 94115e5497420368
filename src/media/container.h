#pragma once

// An opened movie or sound file, packet by packet. Private to the module.

#include "ffmpeg.h"
#include "frame_image.h"
#include "stream_clocks.h"

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <earpoint/media/media.h>

namespace earpoint::ffmpeg {

struct FileDeleter {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
struct IoDeleter {
  void operator()(AVIOContext* io) const {
    av_freep(&io->buffer);
    avio_context_free(&io);
  }
};
struct InputFormatDeleter {
  void operator()(AVFormatContext* format) const { avformat_close_input(&format); }
};

/// Reads packets of a container. FFmpeg is given only this one open file: whatever a container
/// refers to (playlists, other files, addresses) is never opened.
class InputContainer {
 public:
  /// @throws InputError if the file is missing or no movie or sound file
  explicit InputContainer(const std::filesystem::path& path);

  [[nodiscard]] AVFormatContext& format() { return *format_; }
  [[nodiscard]] const AVStream& stream(int index) const;
  /// Index in the container. @throws InputError if there is no stream of that kind
  [[nodiscard]] int preferred_stream(StreamKind kind) const;
  [[nodiscard]] MediaInfo describe() const;
  [[nodiscard]] StreamInfo describe(int index) const;
  /// Rotation by the display matrix.
  [[nodiscard]] Orientation orientation(int index) const;

  /// The container's start: what t = 0 means, in the container's own time.
  [[nodiscard]] double origin_s() const { return origin_s_; }
  /// @return seconds since the container's start; nothing if the timestamp is missing
  [[nodiscard]] std::optional<double> time_s(int stream, std::int64_t timestamp) const;
  [[nodiscard]] std::int64_t timestamp(int stream, double time_s) const;

  /// "clip.mp4: video stream 0" or "clip.mp4: video stream 0 at 1.250 s"
  [[nodiscard]] std::string where(int stream) const;
  [[nodiscard]] std::string where(int stream, std::optional<double> time_s) const;

  /// Drops every other stream's packets.
  void select(int stream);
  /// The next packet of the selected stream.
  /// @return false at the end
  /// @throws InputError naming stream and time if the file is damaged or ends too early
  bool read(AVPacket& packet);
  /// What the user should know of what was read so far, each one line without the file's name.
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }
  void warn(std::string warning) { warnings_.push_back(std::move(warning)); }
  /// Goes to a key frame at or before the timestamp. @return false if the file cannot do that
  bool seek(int stream, std::int64_t timestamp);

 private:
  void open();
  void find_origin();
  [[nodiscard]] bool may_jump() const;
  void join_clocks(AVPacket& packet);
  void check_packet(AVPacket& packet);
  void check_whole(int error);
  [[noreturn]] void throw_damaged(int error) const;

  std::filesystem::path path_;
  // Closed in the reverse of this order.
  std::unique_ptr<std::FILE, FileDeleter> file_;
  std::unique_ptr<AVIOContext, IoDeleter> io_;
  std::unique_ptr<AVFormatContext, InputFormatDeleter> format_;
  double origin_s_ = 0.0;
  int selected_ = -1;
  std::optional<int> suspect_;  // packets until one is damaged, unless time jumps before
  bool has_no_length_ = false;  // written to a pipe: its header leaves the length open
  StreamClocks clocks_;         // of containers whose times may jump
  std::vector<std::string> warnings_;
  std::optional<double> last_time_s_;  // of the packet read last, for messages
};

/// When the last packet of a stream ends, found by reading all of them: for containers that do not
/// state a duration.
/// @throws InputError as InputContainer
double measured_end_s(const std::filesystem::path& path, int stream);

}  // namespace earpoint::ffmpeg
