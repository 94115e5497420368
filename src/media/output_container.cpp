#include "output_container.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <new>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <earpoint/error.h>

extern "C" {
#include <libavutil/dict.h>
}

namespace earpoint::ffmpeg {
namespace fs = std::filesystem;

namespace {

constexpr int kIoBufferBytes = 1 << 18;

[[noreturn]] void throw_unwritable(const fs::path& path, int error) {
  throw InputError(
      path.string(), fmt::format("cannot be written ({})", std::generic_category().message(error)),
      error == ENOSPC || error == EDQUOT ? "free some space, or choose another disk" : "");
}

/// FFmpeg's name of the container that the extension asks for.
const char* format_of(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension == ".mp4" || extension == ".m4v") return "mp4";
  if (extension == ".mov") return "mov";
  if (extension == ".mkv") return "matroska";
  throw InputError(
      path.string(),
      fmt::format("movies are written as .mp4, .m4v, .mov or .mkv, not '{}'", extension));
}

}  // namespace

OutputFile::OutputFile(const fs::path& path)
    : descriptor_(::open(path.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) throw_unwritable(path, errno);
  auto* buffer = static_cast<unsigned char*>(av_malloc(kIoBufferBytes));
  if (buffer != nullptr) {
    io_ = avio_alloc_context(buffer, kIoBufferBytes, /*write_flag=*/1, this, nullptr, write_bytes,
                             seek_bytes);
  }
  if (io_ != nullptr) return;
  av_free(buffer);
  ::close(descriptor_);
  throw std::bad_alloc();
}

OutputFile::~OutputFile() {
  av_freep(&io_->buffer);
  avio_context_free(&io_);
  ::close(descriptor_);
}

int OutputFile::write_bytes(void* self, std::uint8_t* bytes, int size) {
  auto* file = static_cast<OutputFile*>(self);
  for (int done = 0; done < size;) {
    const ssize_t count =
        ::write(file->descriptor_, bytes + done, static_cast<std::size_t>(size - done));
    if (count > 0) {
      done += static_cast<int>(count);
    } else if (errno != EINTR) {
      if (file->error_ == 0) file->error_ = errno;
      return AVERROR(errno);
    }
  }
  return size;
}

std::int64_t OutputFile::seek_bytes(void* self, std::int64_t offset, int whence) {
  auto* file = static_cast<OutputFile*>(self);
  if (whence & AVSEEK_SIZE) return AVERROR(ENOSYS);
  const off_t position = ::lseek(file->descriptor_, offset, whence & ~AVSEEK_FORCE);
  return position < 0 ? AVERROR(errno) : position;
}

OutputContainer::OutputContainer(const fs::path& path)
    : path_(path), format_name_(format_of(path)), file_(path), output_(file_.temporary_path()) {
  listen_to_log();
  AVFormatContext* format = nullptr;
  check_memory(avformat_alloc_output_context2(&format, nullptr, format_name_, nullptr));
  format_.reset(format);
  format_->pb = output_.io();
  format_->flags |= AVFMT_FLAG_CUSTOM_IO | AVFMT_FLAG_BITEXACT;
  // Moving the index to the front reads the file again, by this name.
  format_->url = av_strdup(("file:" + file_.temporary_path().string()).c_str());
  if (format_->url == nullptr) throw std::bad_alloc();
}

void OutputContainer::check_written(int error) {
  if (output_.error() != 0) throw_unwritable(path_, output_.error());
  if (error >= 0) error = output_.io()->error;
  check(error, path_.string(), "cannot be written");
}

AVStream& OutputContainer::add_stream(const AVCodecParameters& codec, AVRational time_base) {
  AVStream* stream = avformat_new_stream(format_.get(), nullptr);
  if (stream == nullptr) throw std::bad_alloc();
  check_memory(avcodec_parameters_copy(stream->codecpar, &codec));
  stream->time_base = time_base;
  return *stream;
}

AVStream& OutputContainer::add_stream(const AVCodecContext& encoder) {
  AVStream* stream = avformat_new_stream(format_.get(), nullptr);
  if (stream == nullptr) throw std::bad_alloc();
  check_memory(avcodec_parameters_from_context(stream->codecpar, &encoder));
  stream->time_base = encoder.time_base;
  if (encoder.codec_type == AVMEDIA_TYPE_VIDEO) stream->avg_frame_rate = encoder.framerate;
  return *stream;
}

void OutputContainer::begin() {
  listen_to_log();
  AVDictionary* options = nullptr;
  av_dict_set(&options, "movflags", "+faststart", 0);
  const int error = avformat_write_header(format_.get(), &options);
  av_dict_free(&options);
  check_written(error);
}

void OutputContainer::write(AVPacket& packet, const AVStream& stream, AVRational time_base) {
  av_packet_rescale_ts(&packet, time_base, stream.time_base);
  packet.stream_index = stream.index;
  packet.pos = -1;
  listen_to_log();
  check_written(av_interleaved_write_frame(format_.get(), &packet));
}

void OutputContainer::finish() {
  listen_to_log();
  const int error = av_write_trailer(format_.get());
  avio_flush(output_.io());
  check_written(error);
  file_.commit();
}

}  // namespace earpoint::ffmpeg
