#pragma once

namespace earpoint::kernels {

// What norms add to a variance before its root. PyTorch's, with which the released networks and
// ours were trained.
inline constexpr double kBatchNormEpsilon = 1e-5;
inline constexpr double kLayerNormEpsilon = 1e-5;
inline constexpr double kGroupNormEpsilon = 1e-5;

}  // namespace earpoint::kernels
