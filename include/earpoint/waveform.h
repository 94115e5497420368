#pragma once

/// earpoint::Waveform: sound in memory, planar, float32, with its sampling rate.
#include <earpoint/core/waveform.h>
