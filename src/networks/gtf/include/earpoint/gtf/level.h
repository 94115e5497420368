#pragma once

#include <span>

#include <earpoint/gtf/training_range.h>
#include <earpoint/pose.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// By how much gtf's level may differ from what geometry expects of a move, in decibels, >= 0.
struct LevelTolerance {
  double louder_db = 0.0;
  double quieter_db = 0.0;
};

/// Hardly anything where nothing moves; more with distance, since walls and the speaker's heading
/// may count for much; and again little beyond the range that the network was trained on, where
/// geometry is all that is known. Continuous in the pose.
[[nodiscard]] LevelTolerance gtf_level_tolerance(const Pose& source_from_target,
                                                 const GtfTrainingRange& range);

/// The same of a window whose target moves: the mean over its poses.
/// @param path  not empty
[[nodiscard]] LevelTolerance gtf_level_tolerance(std::span<const Pose> path,
                                                 const GtfTrainingRange& range);

/// Powers that a sound may have, over that of the source.
struct LevelBounds {
  double least = 0.0;
  double most = 0.0;
};

/// Nothing gets louder than the source by more than 12 dB, unless the speaker's place is known and
/// geometry itself expects that.
/// @param expected_gain  of power, both ears together, as Gtf::expected_gain() has it
/// @param knows_place    whether the speaker's place was given and not estimated
[[nodiscard]] LevelBounds gtf_level_bounds(double expected_gain, const LevelTolerance& tolerance,
                                           bool knows_place);

/// Scales a window where its level differs from the expected one by more than it may.
/// @param source  2 ears, [samples], what the network heard
/// @param result  the same size, what it made of that
void limit_level(const Waveform& source, double expected_gain, const LevelTolerance& tolerance,
                 bool knows_place, Waveform& result);

/// Makes a window that is louder than the source by more than 12 dB quieter, until it is by 12 dB.
/// @param source, result  as above
void limit_loudness(const Waveform& source, Waveform& result);

}  // namespace earpoint
