#include "stream_clocks.h"

#include <cmath>

namespace earpoint::ffmpeg {

std::optional<double> StreamClocks::join(AVPacket& packet, double tick_s) {
  constexpr double kForward_s = 10.0;  // a pause of the recording may be that long
  constexpr double kBackward_s = 0.5;  // decoding times never go back
  const std::int64_t stamp = packet.dts != AV_NOPTS_VALUE ? packet.dts : packet.pts;
  if (stamp == AV_NOPTS_VALUE) return std::nullopt;
  const auto stream = static_cast<std::size_t>(packet.stream_index);
  if (clocks_.size() <= stream) clocks_.resize(stream + 1);  // streams may begin in mid-file
  Clock& clock = clocks_[stream];
  std::optional<double> joint_s;
  const double start_s = static_cast<double>(stamp) * tick_s;
  const double jump_s = clock.end_s ? start_s + clock.offset_s - *clock.end_s : 0.0;
  if (jump_s > kForward_s || jump_s < -kBackward_s) {
    // The first stream that meets a jump sets its length; the others stay in sync with it.
    const bool is_known =
        clock.jumps < jumps_s_.size() && std::abs(jumps_s_[clock.jumps] - jump_s) < kForward_s;
    if (!is_known) {
      joint_s = clock.end_s;
      jumps_s_.resize(clock.jumps);
      jumps_s_.push_back(jump_s);
    }
    clock.offset_s -= jumps_s_[clock.jumps++];
    clock.since_jump = 0;
  } else {
    ++clock.since_jump;
  }
  const std::int64_t shift = std::llround(clock.offset_s / tick_s);
  if (packet.dts != AV_NOPTS_VALUE) packet.dts += shift;
  if (packet.pts != AV_NOPTS_VALUE) packet.pts += shift;
  clock.end_s = start_s + clock.offset_s + static_cast<double>(packet.duration) * tick_s;
  return joint_s;
}

int StreamClocks::since_jump(int stream) const {
  const auto index = static_cast<std::size_t>(stream);
  return index < clocks_.size() ? clocks_[index].since_jump : Clock{}.since_jump;
}

}  // namespace earpoint::ffmpeg
