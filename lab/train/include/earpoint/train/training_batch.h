#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace earpoint {

/// One clip as a network is trained on it.
struct TrainingExample {
  std::vector<float> source;   ///< planar, [audio channels][samples], left ear first
  std::vector<float> target;   ///< same shape; empty where no sound is to be made
  std::vector<float> picture;  ///< [3][height][width], 0 to 1; empty without an image encoder
  /// By name, e.g. "tgt_pose": the network's inputs but those that it makes of the picture.
  std::map<std::string, std::vector<float>> inputs;
};

/// Clips of equal length, one after the other: every array has a first axis of `clips`.
struct TrainingBatch {
  std::int64_t clips = 0;
  std::vector<float> source;
  std::vector<float> target;
  std::vector<float> pictures;
  std::map<std::string, std::vector<float>> inputs;
};

/// Joins examples of equal shapes. @throws std::logic_error if there are none or they differ
[[nodiscard]] TrainingBatch join(std::span<const TrainingExample> examples);

/// A copy of `count` clips of a batch. @throws std::logic_error if it has not so many
[[nodiscard]] TrainingBatch clips_of(const TrainingBatch& batch, std::int64_t first,
                                     std::int64_t count);

}  // namespace earpoint
