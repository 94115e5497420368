#include "ffmpeg.h"

#include <array>
#include <cstdarg>
#include <cstdio>
#include <mutex>
#include <new>

#include <earpoint/error.h>

namespace earpoint::ffmpeg {
namespace {

// Per thread, so that readers in different threads do not mix their messages. Messages of FFmpeg's
// own worker threads are lost; the error number still arrives.
thread_local std::string complaint;

void hear(void* /*source*/, int level, const char* format, std::va_list arguments) {
  // The first message is the cause, the later ones are its consequences.
  if (level > AV_LOG_ERROR || !complaint.empty()) return;
  std::array<char, 512> line{};
  // NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): comes from av_log
  std::vsnprintf(line.data(), line.size(), format, arguments);
  std::string text(line.data());
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ' || c == 0x7f) c = ' ';
  }
  const std::size_t end = text.find_last_not_of(" .");
  text.resize(end == std::string::npos ? 0 : end + 1);
  complaint = std::move(text);
}

}  // namespace

PacketPtr make_packet() {
  PacketPtr packet(av_packet_alloc());
  if (!packet) throw std::bad_alloc();
  return packet;
}

FramePtr make_frame() {
  FramePtr frame(av_frame_alloc());
  if (!frame) throw std::bad_alloc();
  return frame;
}

CodecContextPtr make_codec_context(const AVCodec* codec) {
  CodecContextPtr context(avcodec_alloc_context3(codec));
  if (!context) throw std::bad_alloc();
  return context;
}

void listen_to_log() {
  static std::once_flag once;
  std::call_once(once, [] { av_log_set_callback(hear); });
  complaint.clear();
}

std::string first_complaint() { return complaint; }

std::string reason(int error) {
  if (!complaint.empty()) return complaint;
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(error, text.data(), text.size());
  return text.data();
}

void check(int error, std::string_view where, std::string_view problem, std::string_view hint) {
  if (error >= 0) return;
  throw InputError(where, std::string(problem) + " (" + reason(error) + ")", hint);
}

void check_memory(int error) {
  if (error < 0) throw std::bad_alloc();
}

}  // namespace earpoint::ffmpeg
