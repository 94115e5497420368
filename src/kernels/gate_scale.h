#pragma once

namespace earpoint::kernels {

/// What packed filter and gate rows are multiplied by (-2 log2 e and -log2 e), so that
/// tanh(f) = (1 - F) / (1 + F) and sigmoid(g) = 1 / (1 + G) with powers of two F and G of the
/// scaled rows.
inline constexpr double kFilterScale = -2.0 * 1.44269504088896340736;
inline constexpr double kGateScale = -1.44269504088896340736;

}  // namespace earpoint::kernels
