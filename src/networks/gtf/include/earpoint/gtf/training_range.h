#pragma once

#include <string>
#include <string_view>

namespace earpoint {

/// Key in a weight file's metadata: the network's training range as JSON.
inline constexpr std::string_view kTrainingRangeKey = "earpoint.training_range";

/// The moves and speakers of the data that a network was trained on, in the source's frame. The
/// engine takes what lies beyond as the nearest within, and rendering warns of it.
///
/// The values here are of simulated homes, and of weight files that do not say: both viewpoints
/// stand within 2.5 m of the middle between two people, who stand within 1.5 m of it; all heads are
/// level, at one height.
struct GtfTrainingRange {
  double farthest_move_m = 5.0;
  double highest_move_m = 0.3;  ///< up or down; people hold cameras by hand
  double farthest_speaker_m = 4.0;
  double highest_speaker_m = 1.0;  ///< the mouth, up or down
  double level_move_m = 0.1;       ///< up or down: rendering warns of more
  double level_head_deg = 5.0;     ///< pitch or roll: rendering warns of more

  friend bool operator==(const GtfTrainingRange&, const GtfTrainingRange&) = default;
};

/// One line, keys sorted.
[[nodiscard]] std::string to_json(const GtfTrainingRange& range);

/// The inverse, checked; keys that are left out keep the values of `range`.
/// @throws InputError naming the key, what was expected and what was found
[[nodiscard]] GtfTrainingRange gtf_training_range_from_json(std::string_view json,
                                                            std::string_view where,
                                                            GtfTrainingRange range = {});

}  // namespace earpoint
