#pragma once

#include <ATen/core/Tensor.h>

namespace earpoint {

/// What a batch's views hold, as tensors; names as in people_example.h.
struct PeopleTargets {
  at::Tensor middles;     ///< [pictures][height][width]
  at::Tensor boxes;       ///< [pictures][4][height][width], pixels
  at::Tensor weights;     ///< [pictures][height][width]
  at::Tensor background;  ///< [pictures][height][width]
};

/// How far the network's answer is off: the focal loss of middles, in which cells near a middle
/// count less as background, and 1 minus the generalised intersection over union of boxes, both per
/// person.
/// Sources: Zhou et al., "Objects as points", 2019, equation 1; Rezatofighi et al., CVPR 2019.
/// @param answer  [pictures][PeopleDescription::kOutputs][height][width]
/// @return        one number
at::Tensor people_loss(const at::Tensor& answer, const PeopleTargets& targets);

/// The boxes of an answer's cells, in pixels of the view: [pictures][4][height][width].
at::Tensor boxes_of_cells(const at::Tensor& answer);

}  // namespace earpoint
