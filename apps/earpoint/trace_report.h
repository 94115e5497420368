#pragma once

#include <span>
#include <string>

#include <earpoint/trace/tracer.h>

namespace earpoint {

/// What `earpoint trace --report` prints: decay measures per octave band, the direct sound's level,
/// and what the trace cost.
/// @param traced   of one pair
/// @param mono     its impulse response
/// @param seconds  that everything took
std::string trace_report(const TraceResult& traced, std::span<const float> mono, int sample_rate_hz,
                         double seconds);

}  // namespace earpoint
