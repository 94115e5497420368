#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/generate/speech_corpus.h>

namespace earpoint {

/// One part of a job that several machines share: shard `index` of `count`.
struct Shard {
  int index = 0;  ///< in [0, count)
  int count = 1;
};

/// Parses "i/n" with 0 <= i < n.
/// @throws InputError
Shard parse_shard(std::string_view text);

/// A conversation to simulate.
struct WorkItem {
  int scene = 0;
  int conversation = 0;  ///< over all of the scene
  std::string split;     ///< the folder: train, val, test or a name that the user chose
  DataSplit voices = DataSplit::train;  ///< which speakers and figures it may use
  int folder = 0;  ///< counts the conversations of the scene within the split: their folder's name
};

/// What is to be made.
struct WorkOrder {
  int scenes = 1;
  int conversations = 1;             ///< per scene
  std::optional<std::string> split;  ///< puts all scenes into one split
};

/// Lists every conversation, scene by scene. Scenes are split 90 : 10 : 20 into train, val and test
/// (the first scenes are train); a single scene's conversations are split so instead. With three or
/// more to split, no part is empty.
/// @throws std::logic_error if a number is not above 0
std::vector<WorkItem> plan_work(const WorkOrder& order);

/// The items of one shard: every count-th scene, or every count-th conversation where there are
/// fewer scenes than shards.
std::vector<WorkItem> items_of_shard(const std::vector<WorkItem>& items, const WorkOrder& order,
                                     const Shard& shard);

/// @return which voices a split may use: train, those of val for names that begin with val, else
///         those of test
DataSplit voices_of_split(std::string_view split);

}  // namespace earpoint
