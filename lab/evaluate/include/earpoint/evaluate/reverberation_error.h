#pragma once

#include <earpoint/rt60/engine.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// The metric RTE: how differently two sounds reverberate. The mean over the ears of the absolute
/// difference of the T60 that the estimator hears in the reference and in the estimate.
/// @param reference, estimate  of as many channels, at 16 kHz; longer or shorter than a second as
///                             in Rt60Estimator::estimate_s()
/// @return  seconds
/// Source: Novel-View Acoustic Synthesis, CVPR 2023, section 5.1, and its released evaluation.
[[nodiscard]] double reverberation_error_s(Rt60Estimator& estimator, const Waveform& reference,
                                           const Waveform& estimate);

}  // namespace earpoint
