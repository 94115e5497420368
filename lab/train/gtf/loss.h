#pragma once

#include "graph.h"
#include "rt60/graph.h"
#include "spectral_loss.h"

#include <ATen/core/Tensor.h>

#include <earpoint/train/gtf_learner.h>

namespace earpoint {

/// What a prediction is measured by.
struct GtfTruth {
  at::Tensor target;           ///< [clips][2][samples]
  at::Tensor spectrum;         ///< spectrum_planes() of it
  at::Tensor dry;              ///< [clips][samples]: the speech; needed where decay counts
  at::Tensor dry_magnitude;    ///< dry_magnitudes() of it; needed where they count
  at::Tensor speaker_m;        ///< [clips][3]: the mouth in the source's frame; zeros if unknown
  at::Tensor speaker_heading;  ///< [clips][2]: cosine and sine of where it looks; zeros if unknown
};

/// Short-time magnitudes of the speech. It is on time where responses have lost their delays.
/// @param dry  [clips][samples]
/// @return     [clips][bins][frames]
at::Tensor dry_magnitudes(const at::Tensor& dry);

/// How far the speakers are from where they are taken to be: a sum of the errors of direction
/// (radians, if small), of distance (of its logarithm), of height (half of it, metres) and of
/// heading (a fifth of the square between unit vectors). Where the truth has zeros for unknown, the
/// position or the heading counts 0.
/// @param truth  needs speaker_m and speaker_heading alone
/// @return       a number: the mean over the clips
at::Tensor place_error(const SpeakerPlace& speaker, const GtfTruth& truth);

/// These clips' share of the loss that the network learns by; see GtfLossWeights. The shares of all
/// clips of a batch add up to its loss.
/// @param estimator  of reverberation time; needed where that counts
at::Tensor gtf_loss(const GtfLossWeights& weights, const GtfOutput& output, const GtfTruth& truth,
                    const BatchShare& share, const Rt60Graph* estimator);

}  // namespace earpoint
