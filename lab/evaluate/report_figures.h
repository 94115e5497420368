#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <earpoint/evaluate/evaluation.h>

namespace earpoint {

/// A map from above, as SVG, 256 x 256: the source looks up the page, and everyone stands where
/// they are around it; rings of a metre.
[[nodiscard]] std::string map_svg(const Pose& source_from_target,
                                  const std::optional<Vector3>& speaker_m);

/// What a curve is drawn over.
struct CurveAxis {
  std::string_view label;
  std::function<double(const ClipResult&)> value;
  bool needs_speaker = false;  ///< it is defined only where the speaker's place is known
};
/// Distance of the viewpoints, turn between them, and the target's distance to the speaker.
[[nodiscard]] std::span<const CurveAxis> curve_axes();

/// Mean of a metric in five bins of equally many clips along the axis, with 95 % intervals drawn by
/// interval_clusters(), a line per method, as SVG.
[[nodiscard]] std::string curve_svg(const EvaluationResult& result, Metric metric,
                                    const CurveAxis& axis);

}  // namespace earpoint
