#pragma once

#include <earpoint/trace/tracer.h>

namespace earpoint {

/// How far a response has decayed where it is cut off.
struct ResponseEnd {
  /// Energy in the last 50 ms over that in the loudest 50 ms, of the octave band that has decayed
  /// least. Minus infinity if no sound is left.
  double level_db = 0.0;
  /// The duration at which it would reach -60 dB, if it went on as in its second half. Infinity if
  /// it does not fall there.
  double needed_s = 0.0;
};

/// @param duration_s  the traced one, > 0
ResponseEnd response_end(const PointResponse& response, double duration_s);

}  // namespace earpoint
