#pragma once

// An mp4 file in the making. Private to the module.

#include "ffmpeg.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include <earpoint/core/file.h>

namespace earpoint::ffmpeg {

struct OutputFormatDeleter {
  void operator()(AVFormatContext* format) const { avformat_free_context(format); }
};

/// Where bytes go: a file descriptor that remembers why the last write failed.
class OutputFile {
 public:
  /// @throws InputError
  explicit OutputFile(const std::filesystem::path& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  [[nodiscard]] AVIOContext* io() { return io_; }
  /// errno of the first write that failed; 0 if none did
  [[nodiscard]] int error() const { return error_; }

 private:
  static int write_bytes(void* self, std::uint8_t* bytes, int size);
  static std::int64_t seek_bytes(void* self, std::int64_t offset, int whence);

  int descriptor_ = -1;
  int error_ = 0;
  AVIOContext* io_ = nullptr;
};

/// Streams are added, then begin(), packets in any order, finish().
class OutputContainer {
 public:
  /// @throws InputError if the path's extension is not .mp4, .m4v, .mov or .mkv, or it cannot be
  ///         written
  explicit OutputContainer(const std::filesystem::path& path);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// FFmpeg's name of the container: "mp4", "mov" or "matroska".
  [[nodiscard]] std::string_view format_name() const { return format_name_; }

  /// A new stream. The file may change its time base in begin().
  AVStream& add_stream(const AVCodecParameters& codec, AVRational time_base);
  AVStream& add_stream(const AVCodecContext& encoder);
  void begin();
  /// Takes the packet over; its times are in `time_base`, t = 0 is the movie's start.
  void write(AVPacket& packet, const AVStream& stream, AVRational time_base);
  /// Writes the index and puts the file into place.
  void finish();

 private:
  void check_written(int error);

  std::filesystem::path path_;
  const char* format_name_;
  AtomicFile file_;
  OutputFile output_;
  std::unique_ptr<AVFormatContext, OutputFormatDeleter> format_;
};

}  // namespace earpoint::ffmpeg
