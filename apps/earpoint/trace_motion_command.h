#pragma once

#include "trace_setup.h"

namespace earpoint {

/// `earpoint trace` along paths, or of a sound: a folder of responses, or what is heard.
/// @param rate_given  else a sound keeps its own
/// @throws InputError
void run_trace_motion(TraceSetup setup, bool rate_given);

}  // namespace earpoint
