#pragma once

#include "frame_planes.h"

namespace earpoint::training {

/// The spectra of a round of phases, rows as FrameExtent has them.
struct PhaseRound {
  const float* start;   ///< whose magnitudes are kept
  const float* heard;   ///< the transform of what the last round sounds like
  const float* before;  ///< the same a round earlier
};

/// The gradients by them.
struct PhaseSlopes {
  float* by_start;   ///< is added to
  float* by_heard;   ///< is added to
  float* by_before;  ///< is overwritten
};

/// turned = |start| z / sqrt(|z|^2 + 1e-8), z = heard + momentum * (heard - before)
void turn_to(const FrameExtent& extent, const PhaseRound& round, float* turned);

/// Its gradient; that by `start` is by its magnitude alone.
void turn_to_back(const FrameExtent& extent, const PhaseRound& round, const float* by_turned,
                  const PhaseSlopes& slopes);

}  // namespace earpoint::training
