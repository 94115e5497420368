#pragma once

namespace earpoint {

/// @throws InputError unless live streams run at this rate: from 16000 to 192000, a multiple of 50
void check_stream_rate(int sample_rate_hz);

}  // namespace earpoint
