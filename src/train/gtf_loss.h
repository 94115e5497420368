#pragma once

#include "gtf_graph.h"
#include "rt60_graph.h"

#include <ATen/core/Tensor.h>

#include <earpoint/train/gtf_learner.h>

namespace earpoint {

/// What a prediction is measured by.
struct GtfTruth {
  at::Tensor target;           ///< [clips][2][samples]
  at::Tensor dry;              ///< [clips][samples]: the speech; needed where decay counts
  at::Tensor speaker_m;        ///< [clips][3]: the mouth in the source's frame
  at::Tensor speaker_heading;  ///< [clips][2]: cosine and sine of where it looks; zeros if unknown
};

/// What some clips of a batch need to know of all of it.
struct BatchShare {
  double clips = 1.0;     ///< these over all
  double loudness = 0.0;  ///< loudness_of() all targets, in sum
};

/// What the phase between the ears is weighed by, summed over all bins.
/// @param target  [clips][2][samples]
double loudness_of(const at::Tensor& target);

/// These clips' share of the loss that the network learns by; see GtfLossWeights. The shares of all
/// clips of a batch add up to its loss.
/// @param estimator  of reverberation time; needed where that counts
at::Tensor gtf_loss(const GtfLossWeights& weights, const GtfOutput& output, const GtfTruth& truth,
                    const BatchShare& share, const Rt60Graph* estimator);

}  // namespace earpoint
