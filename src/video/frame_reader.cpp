#include "container.h"
#include "frame_image.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <earpoint/core/error.h>
#include <earpoint/video/media.h>

namespace earpoint {
namespace {

using ffmpeg::FramePtr;

/// Beyond this a key frame further on is worth a seek instead of decoding all that lies between.
constexpr double kSeekForwardAfter_s = 2.0;

struct TimedFrame {
  FramePtr frame;  // none: there is no such frame
  double time_s = 0.0;
};

}  // namespace

struct FrameReader::State {
  explicit State(const std::filesystem::path& file) : path(file) {
    rewind();
    info = container->describe(stream);
    const std::size_t wanted = 9 * sizeof(std::int32_t);
    std::size_t bytes = 0;
    const std::uint8_t* matrix =
        av_stream_get_side_data(&container->stream(stream), AV_PKT_DATA_DISPLAYMATRIX, &bytes);
    if (matrix != nullptr && bytes >= wanted) {
      orientation =
          ffmpeg::orientation_from_display_matrix(reinterpret_cast<const std::int32_t*>(matrix));
    }
  }

  // Opens the file anew: the only way back to the first frame that works for every container.
  void rewind() {
    decoder.reset();
    container = std::make_unique<ffmpeg::InputContainer>(path);
    stream = container->preferred_stream(StreamKind::video);
    decoder = std::make_unique<ffmpeg::StreamDecoder>(*container, stream);
    forget_position();
  }

  void forget_position() {
    current = {};
    upcoming = {};
    has_position = false;
    is_first = false;
  }

  /// The decoder's next frame; its time never goes back.
  TimedFrame decode() {
    TimedFrame next{ffmpeg::make_frame(), 0.0};
    if (!decoder->next(*next.frame)) return {};
    ++frames_decoded;
    const double step_s = info.frame_rate_hz > 0.0 ? 1.0 / info.frame_rate_hz : 0.0;
    const double expected_s = last_time_s ? *last_time_s + step_s : 0.0;
    const auto stamped_s = container->time_s(stream, next.frame->best_effort_timestamp);
    next.time_s = stamped_s.value_or(expected_s);
    if (last_time_s) next.time_s = std::max(next.time_s, *last_time_s);
    last_time_s = next.time_s;
    has_timestamps = has_timestamps && stamped_s.has_value();
    return next;
  }

  /// Decodes the two frames from where the decoder is. @return false if there is none
  bool take_position(bool at_first) {
    last_time_s.reset();
    current = decode();
    if (!current.frame) return false;
    upcoming = decode();
    is_first = at_first;
    has_position = true;
    return true;
  }

  void start() {
    if (!take_position(/*at_first=*/true)) {
      throw InputError(container->where(stream), "holds no picture", ffmpeg::kDamagedMend);
    }
  }

  /// Goes to a frame at or before the time, or to the first frame.
  void seek_before(double time_s) {
    for (double back_s = 0.0; has_timestamps && time_s - back_s > 0.0;
         back_s = 2.0 * back_s + 0.5) {
      forget_position();
      has_sought = true;
      if (!decoder->seek(container->timestamp(stream, time_s - back_s))) break;
      if (take_position(/*at_first=*/false) && has_timestamps && current.time_s <= time_s) return;
    }
    rewind();
    start();
  }

  [[nodiscard]] bool seeking_forward_pays(double time_s) {
    if (!upcoming.frame || time_s - upcoming.time_s <= kSeekForwardAfter_s) return false;
    // Matroska reads its index when first sought in; until then there is nothing to look up.
    if (!has_sought) return true;
    AVStream* source = container->format().streams[stream];
    const int entry = av_index_search_timestamp(source, container->timestamp(stream, time_s),
                                                AVSEEK_FLAG_BACKWARD);
    const AVIndexEntry* key = entry < 0 ? nullptr : avformat_index_get_entry(source, entry);
    if (key == nullptr) return false;
    const auto key_s = container->time_s(stream, key->timestamp);
    return key_s && *key_s > upcoming.time_s;
  }

  /// Makes `current` the last frame that is not after the time (or the first frame).
  void go_to(double time_s) {
    if (!has_position) start_anew();
    if (time_s < current.time_s ? !is_first : seeking_forward_pays(time_s)) seek_before(time_s);
    while (upcoming.frame && upcoming.time_s <= time_s) {
      current = std::exchange(upcoming, {});
      is_first = false;
      upcoming = decode();
    }
  }

  void start_anew() {
    if (has_begun) rewind();  // after an error nothing is known about the decoder
    has_begun = true;
    start();
  }

  std::filesystem::path path;
  std::unique_ptr<ffmpeg::InputContainer> container;
  std::unique_ptr<ffmpeg::StreamDecoder> decoder;
  int stream = 0;
  StreamInfo info;
  ffmpeg::Orientation orientation;
  ffmpeg::ImageMaker maker;

  TimedFrame current;
  TimedFrame upcoming;
  bool has_begun = false;
  bool has_sought = false;
  bool has_position = false;
  bool is_first = false;       // `current` is the stream's first frame
  bool has_timestamps = true;  // every frame so far had one; without, seeking tells no time
  std::optional<double> last_time_s;
  std::optional<double> returned_time_s;
  std::int64_t frames_decoded = 0;
};

FrameReader::FrameReader(const std::filesystem::path& path)
    : state_(std::make_unique<State>(path)) {}
FrameReader::~FrameReader() = default;
FrameReader::FrameReader(FrameReader&&) noexcept = default;
FrameReader& FrameReader::operator=(FrameReader&&) noexcept = default;

Image FrameReader::frame_nearest(double time_s) {
  EARPOINT_CHECK(std::isfinite(time_s));
  State& state = *state_;
  try {
    state.go_to(time_s);
  } catch (...) {
    state.forget_position();
    throw;
  }
  constexpr double tie_s = 1e-6;  // finer than any container's clock
  const bool is_later_nearer = state.upcoming.frame && state.upcoming.time_s - time_s <
                                                           time_s - state.current.time_s - tie_s;
  const TimedFrame& nearest = is_later_nearer ? state.upcoming : state.current;
  state.returned_time_s = nearest.time_s;
  const std::string where = state.container->where(state.stream, nearest.time_s);
  return ffmpeg::oriented(state.maker.image(*nearest.frame, where), state.orientation);
}

double FrameReader::frame_time_s() const {
  EARPOINT_CHECK(state_->returned_time_s.has_value());
  return *state_->returned_time_s;
}

std::int64_t FrameReader::frames_decoded() const { return state_->frames_decoded; }
const StreamInfo& FrameReader::info() const { return state_->info; }

double FrameReader::duration_s() const {
  const StreamInfo& info = state_->info;
  if (info.duration_s) return info.start_s + *info.duration_s;
  return state_->container->describe().duration_s.value_or(0.0);
}

}  // namespace earpoint
