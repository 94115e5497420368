#pragma once

// Times of containers whose clock jumps within the file. Private to the module.

#include "ffmpeg.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace earpoint::ffmpeg {

/// Joins the pieces of a recording whose clock jumps, as where broadcast streams were cut: each
/// packet follows the one before it in its stream, and a jump is as long in all streams.
class StreamClocks {
 public:
  /// Shifts the packet's times so that they go on where its stream was.
  /// @param tick_s  the unit of the packet's times
  /// @return  where a jump is that no stream has come to before, seconds of the joined clock
  std::optional<double> join(AVPacket& packet, double tick_s);

  /// @return  packets of a stream since its clock jumped last; many if it never did
  [[nodiscard]] int since_jump(int stream) const;

 private:
  /// Where a stream is in time.
  struct Clock {
    std::optional<double> end_s;  // of the packet before
    double offset_s = 0.0;        // closes the jumps so far
    std::size_t jumps = 0;
    int since_jump = 1000;  // packets
  };

  std::vector<Clock> clocks_;    // by stream
  std::vector<double> jumps_s_;  // found so far, the same for all streams
};

}  // namespace earpoint::ffmpeg
