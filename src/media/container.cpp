#include "container.h"

#include "exif.h"
#include "frame_image.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include <earpoint/core/wav_data.h>
#include <earpoint/error.h>

extern "C" {
#include <libavutil/avstring.h>
#include <libavutil/channel_layout.h>
#include <libavutil/dict.h>
#include <libavutil/opt.h>
}

namespace earpoint::ffmpeg {
namespace fs = std::filesystem;

namespace {

constexpr const char* kContainers =
    "mov,mp4,matroska,webm,avi,mpegts,mpeg,wav,w64,aiff,caf,au,flac,ogg,mp3,aac";
constexpr int kIoBufferBytes = 1 << 16;

int read_bytes(void* file, std::uint8_t* buffer, int size) {
  auto* stream = static_cast<std::FILE*>(file);
  const std::size_t count = std::fread(buffer, 1, static_cast<std::size_t>(size), stream);
  if (count > 0) return static_cast<int>(count);
  return std::ferror(stream) != 0 ? AVERROR(EIO) : AVERROR_EOF;
}

std::int64_t seek_bytes(void* file, std::int64_t offset, int whence) {
  auto* stream = static_cast<std::FILE*>(file);
  if (whence == AVSEEK_SIZE) {
    const off_t here = ftello(stream);
    if (fseeko(stream, 0, SEEK_END) != 0) return AVERROR(errno);
    const off_t size = ftello(stream);
    if (fseeko(stream, here, SEEK_SET) != 0) return AVERROR(errno);
    return size;
  }
  if (fseeko(stream, offset, whence & ~AVSEEK_FORCE) != 0) return AVERROR(errno);
  return ftello(stream);
}

int refuse_to_open(AVFormatContext* /*format*/, AVIOContext** /*io*/, const char* /*url*/,
                   int /*flags*/, AVDictionary** /*options*/) {
  return AVERROR(EPERM);
}

StreamKind kind_of(const AVStream& stream) {
  if (stream.disposition & AV_DISPOSITION_ATTACHED_PIC) return StreamKind::attached_picture;
  switch (stream.codecpar->codec_type) {
    case AVMEDIA_TYPE_VIDEO:
      return StreamKind::video;
    case AVMEDIA_TYPE_AUDIO:
      return StreamKind::audio;
    default:
      return StreamKind::other;
  }
}

const char* name_of(StreamKind kind) {
  switch (kind) {
    case StreamKind::video:
      return "video";
    case StreamKind::audio:
      return "audio";
    case StreamKind::attached_picture:
      return "attached picture";
    default:
      return "other";
  }
}

/// @throws InputError unless it is a container that this module reads
const AVInputFormat* container_kind(AVIOContext& io, const fs::path& path) {
  const AVInputFormat* kind = nullptr;
  if (av_probe_input_buffer2(&io, &kind, path.c_str(), nullptr, 0, 0) < 0) {
    throw InputError(path.string(), "is not a movie or sound file of a known kind");
  }
  if (av_match_list(kind->name, kContainers, ',') == 0) {
    throw InputError(path.string(), fmt::format("is not a movie or sound file but {}",
                                                kind->long_name ? kind->long_name : kind->name));
  }
  return kind;
}

/// When the first sample or picture is due: priming comes before it.
std::optional<double> start_of(const AVStream& stream) {
  if (stream.start_time == AV_NOPTS_VALUE) return std::nullopt;
  const double start_s = static_cast<double>(stream.start_time) * av_q2d(stream.time_base);
  const AVCodecParameters& codec = *stream.codecpar;
  if (codec.initial_padding <= 0 || codec.sample_rate <= 0 || start_s >= 0.0) return start_s;
  return std::min(0.0, start_s + static_cast<double>(codec.initial_padding) / codec.sample_rate);
}

/// Options that keep a damaged header from taking all memory, one dictionary for each stream.
class ProbeOptions {
 public:
  explicit ProbeOptions(unsigned streams) : options_(streams, nullptr) {
    for (AVDictionary*& options : options_) {
      av_dict_set_int(&options, "max_pixels", kMaxPixels, 0);
      av_dict_set_int(&options, "threads", 1, 0);
    }
  }
  ~ProbeOptions() {
    for (AVDictionary*& options : options_) av_dict_free(&options);
  }
  ProbeOptions(const ProbeOptions&) = delete;
  ProbeOptions& operator=(const ProbeOptions&) = delete;
  AVDictionary** get() { return options_.data(); }

 private:
  std::vector<AVDictionary*> options_;
};

Orientation orientation_of(const AVStream& stream) {
  std::size_t bytes = 0;
  const std::uint8_t* matrix = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, &bytes);
  if (matrix == nullptr || bytes < 9 * sizeof(std::int32_t)) return {};
  return orientation_from_display_matrix(reinterpret_cast<const std::int32_t*>(matrix));
}

/// The lens that Apple's cameras note, in the stream's or the movie's metadata; 0 if none.
double focal_length_35mm(const AVStream& stream, const AVFormatContext& format) {
  constexpr const char* kKey = "com.apple.quicktime.camera.focal_length.35mm_equivalent";
  for (const AVDictionary* metadata : {stream.metadata, format.metadata}) {
    const AVDictionaryEntry* entry = av_dict_get(metadata, kKey, nullptr, 0);
    const double length = entry != nullptr ? std::atof(entry->value) : 0.0;
    if (length > 1.0 && length < 10'000.0) return length;
  }
  return 0.0;
}

void describe_picture(const AVStream& stream, const AVFormatContext& format, StreamInfo& info) {
  const AVCodecParameters& codec = *stream.codecpar;
  const Orientation orientation = orientation_of(stream);
  info.rotation_deg = rotation_deg(orientation);
  info.width = codec.width;
  info.height = codec.height;
  if (orientation.xx == 0) std::swap(info.width, info.height);
  const double focal_length = focal_length_35mm(stream, format);
  if (focal_length > 0.0 && info.width > 0 && info.height > 0) {
    info.horizontal_fov_rad = horizontal_fov_rad(focal_length, info.width, info.height);
  }
  const AVRational rate =
      stream.avg_frame_rate.num > 0 ? stream.avg_frame_rate : stream.r_frame_rate;
  if (info.kind == StreamKind::video && rate.num > 0 && rate.den > 0) {
    info.frame_rate_hz = av_q2d(rate);
  }
}

void describe_sound(const AVStream& stream, StreamInfo& info) {
  const AVCodecParameters& codec = *stream.codecpar;
  info.channels = codec.ch_layout.nb_channels;
  info.sample_rate_hz = codec.sample_rate;
  std::array<char, 128> layout{};
  if (av_channel_layout_describe(&codec.ch_layout, layout.data(), layout.size()) > 0) {
    info.channel_layout = layout.data();
  }
}

}  // namespace

InputContainer::InputContainer(const fs::path& path) : path_(path) {
  listen_to_log();
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (!fs::exists(status)) throw InputError(path.string(), "no such file");
  if (!fs::is_regular_file(status)) throw InputError(path.string(), "is not a file");
  if (fs::file_size(path, ignored) == 0) throw InputError(path.string(), "is empty");
  file_.reset(std::fopen(path.c_str(), "rbe"));
  if (!file_) throw InputError(path.string(), "cannot be opened", "check its permissions");
  open();
}

void InputContainer::open() {
  auto* buffer = static_cast<unsigned char*>(av_malloc(kIoBufferBytes));
  if (buffer == nullptr) throw std::bad_alloc();
  io_.reset(avio_alloc_context(buffer, kIoBufferBytes, /*write_flag=*/0, file_.get(), read_bytes,
                               nullptr, seek_bytes));
  if (!io_) av_free(buffer);
  if (!io_) throw std::bad_alloc();
  const AVInputFormat* kind = container_kind(*io_, path_);
  AVFormatContext* format = avformat_alloc_context();
  if (format == nullptr) throw std::bad_alloc();
  format->pb = io_.get();
  format->io_open = refuse_to_open;

  constexpr const char* kProblem = "cannot be opened as a movie or sound file";
  // Frees the context itself if it fails.
  check(avformat_open_input(&format, path_.c_str(), kind, nullptr), path_.string(), kProblem,
        kDamagedHint);
  format_.reset(format);
  if (std::strcmp(kind->name, "wav") == 0) {
    const std::optional<WavData> data = find_wav_data(path_);
    has_no_length_ = data && data->goes_to_the_end();
  }
  ProbeOptions options(format_->nb_streams);
  check(avformat_find_stream_info(format_.get(), options.get()), path_.string(), kProblem,
        kDamagedHint);
  find_origin();
}

void InputContainer::find_origin() {
  bool has_start = false;
  for (unsigned i = 0; i < format_->nb_streams; ++i) {
    const AVStream& stream = *format_->streams[i];
    const StreamKind kind = kind_of(stream);
    if (kind != StreamKind::video && kind != StreamKind::audio) continue;
    const auto start_s = start_of(stream);
    if (!start_s) continue;
    origin_s_ = has_start ? std::min(origin_s_, *start_s) : *start_s;
    has_start = true;
  }
}

const AVStream& InputContainer::stream(int index) const {
  EARPOINT_CHECK(index >= 0 && static_cast<unsigned>(index) < format_->nb_streams);
  return *format_->streams[index];
}

int InputContainer::preferred_stream(StreamKind kind) const {
  const MediaInfo info = describe();
  const StreamInfo* stream = info.preferred(kind);
  if (stream == nullptr) {
    throw InputError(path_.string(), fmt::format("has no {} stream", name_of(kind)));
  }
  return stream->index;
}

StreamInfo InputContainer::describe(int index) const {
  const AVStream& source = stream(index);
  StreamInfo info;
  info.index = index;
  info.kind = kind_of(source);
  info.codec = avcodec_get_name(source.codecpar->codec_id);
  info.is_default = (source.disposition & AV_DISPOSITION_DEFAULT) != 0;
  info.start_s = std::max(0.0, time_s(index, source.start_time).value_or(0.0));
  if (source.duration != AV_NOPTS_VALUE && source.duration > 0 && !may_jump()) {
    info.duration_s = static_cast<double>(source.duration) * av_q2d(source.time_base);
  }
  if (source.codecpar->codec_type == AVMEDIA_TYPE_VIDEO) describe_picture(source, *format_, info);
  if (source.codecpar->codec_type == AVMEDIA_TYPE_AUDIO) describe_sound(source, info);
  return info;
}

MediaInfo InputContainer::describe() const {
  if (format_->nb_streams == 0) {
    throw InputError(path_.string(), "has neither sound nor pictures");
  }
  MediaInfo info;
  info.format = format_->iformat->name;
  info.kind = MediaKind::sound;
  for (unsigned i = 0; i < format_->nb_streams; ++i) {
    info.streams.push_back(describe(static_cast<int>(i)));
    const StreamInfo& stream = info.streams.back();
    if (stream.kind == StreamKind::video) info.kind = MediaKind::movie;
    if (!stream.duration_s || stream.kind == StreamKind::other) continue;
    const double end_s = stream.start_s + *stream.duration_s;
    info.duration_s = std::max(info.duration_s.value_or(0.0), end_s);
  }
  if (!info.duration_s && !may_jump() && format_->duration != AV_NOPTS_VALUE &&
      format_->duration > 0) {
    info.duration_s = static_cast<double>(format_->duration) / AV_TIME_BASE;
  }
  return info;
}

Orientation InputContainer::orientation(int index) const { return orientation_of(stream(index)); }

std::optional<double> InputContainer::time_s(int index, std::int64_t timestamp) const {
  if (timestamp == AV_NOPTS_VALUE) return std::nullopt;
  return static_cast<double>(timestamp) * av_q2d(stream(index).time_base) - origin_s_;
}

std::int64_t InputContainer::timestamp(int index, double time_s) const {
  const double ticks = (time_s + origin_s_) / av_q2d(stream(index).time_base);
  return std::llround(std::clamp(ticks, -9.0e18, 9.0e18));
}

std::string InputContainer::where(int index) const {
  return fmt::format("{}: {} stream {}", path_.string(), name_of(kind_of(stream(index))), index);
}

std::string InputContainer::where(int index, std::optional<double> time_s) const {
  return time_s ? fmt::format("{} at {:.3f} s", where(index), *time_s) : where(index);
}

void InputContainer::select(int index) {
  selected_ = index;
  // Where times may jump, the other streams are watched: a jump is as long in all of them.
  if (may_jump()) {
    clocks_ = {};
    return;
  }
  for (unsigned i = 0; i < format_->nb_streams; ++i) {
    format_->streams[i]->discard = static_cast<int>(i) == index ? AVDISCARD_DEFAULT : AVDISCARD_ALL;
  }
}

/// Broadcast streams are cut and joined without adjusting their clocks, and state no length.
bool InputContainer::may_jump() const {
  return av_match_list(format_->iformat->name, "mpegts,mpeg", ',') != 0;
}

void InputContainer::join_clocks(AVPacket& packet) {
  const AVStream& source = stream(packet.stream_index);
  const StreamKind kind = kind_of(source);
  if (kind != StreamKind::video && kind != StreamKind::audio) return;
  const std::optional<double> joint_s = clocks_.join(packet, av_q2d(source.time_base));
  if (!joint_s) return;
  warn(fmt::format("its clock jumps after {:.3f} s; the parts are joined there",
                   *joint_s - origin_s_));
}

void InputContainer::throw_damaged(int error) const {
  throw InputError(where(selected_, last_time_s_),
                   "the file is damaged or ends too early after this (" + reason(error) + ")",
                   kDamagedHint);
}

void InputContainer::check_whole(int error) {
  // These two know from their index that a file was cut short, but only log it.
  const bool knows_its_end =
      av_match_list(format_->iformat->name, "mov,matroska", ',') != 0 && !first_complaint().empty();
  if (error != AVERROR_EOF || io_->error < 0 || knows_its_end) throw_damaged(error);
}

bool InputContainer::read(AVPacket& packet) {
  listen_to_log();
  for (;;) {
    const int error = av_read_frame(format_.get(), &packet);
    if (error == AVERROR(EAGAIN)) continue;
    if (error < 0) {
      if (suspect_) throw_damaged(AVERROR_INVALIDDATA);
      check_whole(error);
      return false;
    }
    if (may_jump()) join_clocks(packet);
    if (packet.stream_index == selected_) break;
    av_packet_unref(&packet);
  }
  const std::int64_t stamp = packet.pts != AV_NOPTS_VALUE ? packet.pts : packet.dts;
  if (const auto time = time_s(selected_, stamp); time && !suspect_) last_time_s_ = time;
  check_packet(packet);
  return true;
}

void InputContainer::check_packet(AVPacket& packet) {
  // Where two transport streams are joined, whole packets on either side count as damaged.
  constexpr int kNearJumpPackets = 4;
  const bool is_near_jump = may_jump() && clocks_.since_jump(selected_) < kNearJumpPackets;
  if (is_near_jump) suspect_.reset();
  // The last block of a file without a length may be shorter.
  if ((packet.flags & AV_PKT_FLAG_CORRUPT) && !has_no_length_ && !is_near_jump) {
    if (!may_jump()) throw_damaged(AVERROR_INVALIDDATA);
    if (!suspect_) suspect_ = kNearJumpPackets;
  }
  if (may_jump()) packet.flags &= ~AV_PKT_FLAG_CORRUPT;
  if (suspect_ && (*suspect_)-- == 0) throw_damaged(AVERROR_INVALIDDATA);
}

bool InputContainer::seek(int index, std::int64_t timestamp) {
  if (may_jump()) return false;  // times do not tell positions
  listen_to_log();
  return av_seek_frame(format_.get(), index, timestamp, AVSEEK_FLAG_BACKWARD) >= 0;
}

double measured_end_s(const fs::path& path, int stream) {
  InputContainer container(path);
  container.select(stream);
  const PacketPtr packet = make_packet();
  double end_s = 0.0;
  while (container.read(*packet)) {
    if (packet->pts != AV_NOPTS_VALUE) {
      end_s = std::max(end_s, *container.time_s(stream, packet->pts + packet->duration));
    }
    av_packet_unref(packet.get());
  }
  return end_s;
}

}  // namespace earpoint::ffmpeg
