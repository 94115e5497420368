#include "frame_sequence.h"

#include <cmath>
#include <utility>

#include <earpoint/error.h>
#include <earpoint/media/media.h>

namespace earpoint {
namespace {

using ffmpeg::TimedFrame;

/// Beyond this, seeking to a later key frame is faster than decoding all frames up to it.
constexpr double kSeekForwardAfterSeconds = 2.0;

}  // namespace

struct FrameReader::State {
  explicit State(const std::filesystem::path& path) : frames(path) {}

  void forget_position() {
    current = {};
    upcoming = {};
    is_first = false;
  }

  /// Takes the two frames from where the sequence is. @return false if there is none
  bool take_position(bool at_first) {
    current = frames.next();
    if (!current.frame) return false;
    upcoming = frames.next();
    is_first = at_first;
    return true;
  }

  void start() {
    if (has_begun) frames.rewind();
    has_begun = true;
    if (!take_position(/*at_first=*/true)) {
      throw InputError(frames.where(), "holds no picture", ffmpeg::kDamagedHint);
    }
  }

  /// Goes to a frame at or before the time, or to the first frame.
  void seek_before(double time_s) {
    has_sought = true;
    double back_s = 0.0;
    while (frames.has_timestamps() && time_s - back_s > 0.0) {
      forget_position();
      if (!frames.seek(time_s - back_s)) break;
      if (take_position(/*at_first=*/false) && frames.has_timestamps() &&
          current.time_s <= time_s) {
        return;
      }
      // The key frame may be later than the requested time; try earlier and earlier.
      back_s = 2.0 * back_s + 0.5;
    }
    forget_position();
    start();
  }

  [[nodiscard]] bool seeking_forward_pays(double time_s) const {
    if (!upcoming.frame || time_s - upcoming.time_s <= kSeekForwardAfterSeconds) return false;
    // Matroska reads its index when first sought in; until then there is nothing to look up.
    if (!has_sought) return true;
    const auto key_s = frames.key_frame_before(time_s);
    return key_s && *key_s > upcoming.time_s;
  }

  /// Makes `current` the last frame that is not after the time (or the first frame).
  void go_to(double time_s) {
    if (!current.frame) start();
    if (time_s < current.time_s ? !is_first : seeking_forward_pays(time_s)) seek_before(time_s);
    while (upcoming.frame && upcoming.time_s <= time_s) {
      current = std::exchange(upcoming, {});
      is_first = false;
      upcoming = frames.next();
    }
  }

  ffmpeg::FrameSequence frames;
  TimedFrame current;     // none: no position, because of the beginning or an error
  TimedFrame upcoming;    // the one after it; none at the end
  bool is_first = false;  // `current` is the stream's first frame
  bool has_begun = false;
  bool has_sought = false;
  std::optional<double> returned_time_s;
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
  constexpr double kTieSeconds = 1e-6;  // finer than any container's clock
  const bool is_later_nearer =
      state.upcoming.frame &&
      state.upcoming.time_s - time_s < time_s - state.current.time_s - kTieSeconds;
  const TimedFrame& nearest = is_later_nearer ? state.upcoming : state.current;
  state.returned_time_s = nearest.time_s;
  return state.frames.image(nearest);
}

double FrameReader::frame_time_s() const {
  EARPOINT_CHECK(state_->returned_time_s.has_value());
  return *state_->returned_time_s;
}

std::int64_t FrameReader::frames_decoded() const { return state_->frames.frames_decoded(); }
const StreamInfo& FrameReader::info() const { return state_->frames.info(); }

double FrameReader::duration_s() const { return state_->frames.duration_s(); }

}  // namespace earpoint
