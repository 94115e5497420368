#include "frame_sequence.h"

#include <algorithm>

#include <earpoint/error.h>

namespace earpoint::ffmpeg {

FrameSequence::FrameSequence(const std::filesystem::path& path) : path_(path) { rewind(); }

void FrameSequence::rewind() {
  // Opening the file anew is the only way back to the first frame that works for every container.
  decoder_.reset();
  container_ = std::make_unique<InputContainer>(path_);
  const int stream = container_->preferred_stream(StreamKind::video);
  info_ = container_->describe(stream);
  orientation_ = container_->orientation(stream);
  decoder_ = std::make_unique<StreamDecoder>(*container_, stream);
  last_time_s_.reset();
}

TimedFrame FrameSequence::next() {
  TimedFrame next{make_frame(), 0.0};
  if (!decoder_->next(*next.frame)) return {};
  ++frames_decoded_;
  const double period_s = info_.frame_rate_hz > 0.0 ? 1.0 / info_.frame_rate_hz : 0.0;
  const auto stamped_s = container_->time_s(info_.index, next.frame->best_effort_timestamp);
  has_timestamps_ = has_timestamps_ && stamped_s.has_value();
  next.time_s = stamped_s.value_or(last_time_s_ ? *last_time_s_ + period_s : 0.0);
  if (last_time_s_) next.time_s = std::max(next.time_s, *last_time_s_);
  last_time_s_ = next.time_s;
  return next;
}

Image FrameSequence::image(const TimedFrame& frame) {
  EARPOINT_CHECK(frame.frame != nullptr);
  const std::string where = container_->where(info_.index, frame.time_s);
  return oriented(maker_.image(*frame.frame, where), orientation_);
}

bool FrameSequence::seek(double time_s) {
  last_time_s_.reset();
  return decoder_->seek(container_->timestamp(info_.index, time_s));
}

std::optional<double> FrameSequence::key_frame_before(double time_s) const {
  AVStream* stream = container_->format().streams[info_.index];
  const int entry = av_index_search_timestamp(stream, container_->timestamp(info_.index, time_s),
                                              AVSEEK_FLAG_BACKWARD);
  const AVIndexEntry* key = entry < 0 ? nullptr : avformat_index_get_entry(stream, entry);
  if (key == nullptr) return std::nullopt;
  return container_->time_s(info_.index, key->timestamp);
}

double FrameSequence::duration_s() {
  if (!duration_s_ && info_.duration_s) duration_s_ = info_.start_s + *info_.duration_s;
  if (!duration_s_) duration_s_ = container_->describe().duration_s;
  if (!duration_s_) duration_s_ = measured_end_s(path_, info_.index);
  return *duration_s_;
}

}  // namespace earpoint::ffmpeg
