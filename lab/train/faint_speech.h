#pragma once

#include <earpoint/core/random.h>
#include <earpoint/dataset/pair_sample.h>

namespace earpoint {

/// Makes the speech fainter, by up to 60 dB, and adds other sounds to what the source hears, as in
/// the pauses of a recording: noise of any colour from that of a quiet room to white, of devices of
/// several sample rates, steady or in bursts, such as of a keyboard, the same at both ears or
/// independent. A target viewpoint hears such noise too, as loud and at the same moments, of other
/// samples: it comes from everywhere. A near microphone does not.
/// @param noise_db  root mean square of the noise, re full scale; steady noise of a device with a
///                  higher rate loses what lies above the sample's band
void make_faint(PairSample& sample, PairTarget target, double noise_db, RandomStream& random);

}  // namespace earpoint
