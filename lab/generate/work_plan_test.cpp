#include <map>
#include <set>

#include <gtest/gtest.h>

#include <earpoint/error.h>
#include <earpoint/generate/work_plan.h>

namespace earpoint {
namespace {

std::map<std::string, std::set<int>> scenes_by_split(const WorkOrder& order) {
  std::map<std::string, std::set<int>> scenes;
  for (const WorkItem& item : plan_work(order)) scenes[item.split].insert(item.scene);
  return scenes;
}

TEST(WorkPlan, ThePapersScenesAreSplitAsThePaperDoes) {
  const auto scenes = scenes_by_split({.scenes = 120, .conversations = 1, .split = {}});
  EXPECT_EQ(scenes.at("train").size(), 90U);
  EXPECT_EQ(scenes.at("val").size(), 10U);
  EXPECT_EQ(scenes.at("test").size(), 20U);
}

TEST(WorkPlan, NoSplitIsEmptyFromThreeScenesOn) {
  for (int count = 3; count < 40; ++count) {
    const auto scenes = scenes_by_split({.scenes = count, .conversations = 2, .split = {}});
    std::size_t all = 0;
    for (const auto& [split, list] : scenes) all += list.size();
    EXPECT_EQ(scenes.size(), 3U) << count;
    EXPECT_EQ(all, static_cast<std::size_t>(count)) << "a scene is in one split only";
    EXPECT_GE(scenes.at("train").size(), 1U);
  }
}

TEST(WorkPlan, ASingleScenesConversationsAreSplit) {
  std::map<std::string, std::vector<int>> folders;
  for (const WorkItem& item : plan_work({.scenes = 1, .conversations = 12, .split = {}})) {
    folders[item.split].push_back(item.folder);
  }
  EXPECT_EQ(folders.at("train").size(), 9U);
  EXPECT_EQ(folders.at("val"), std::vector<int>{0});
  EXPECT_EQ(folders.at("test"), (std::vector<int>{0, 1}));
}

TEST(WorkPlan, ANamedSplitHoldsAllWithItsVoices) {
  for (const WorkItem& item : plan_work({.scenes = 4, .conversations = 1, .split = "val-seen"})) {
    EXPECT_EQ(item.split, "val-seen");
    EXPECT_EQ(item.voices, DataSplit::val);
  }
  EXPECT_EQ(voices_of_split("train"), DataSplit::train);
  EXPECT_EQ(voices_of_split("demo"), DataSplit::test);
}

TEST(WorkPlan, ShardsShareAllWorkAndKeepScenesWholeWhereTheyCan) {
  for (const int count : {2, 3, 7}) {
    for (const int scenes : {1, 3, 8}) {
      const WorkOrder order{.scenes = scenes, .conversations = 5, .split = {}};
      const auto items = plan_work(order);
      std::set<std::pair<int, int>> seen;
      std::map<int, std::set<int>> shards_of_scene;
      for (int shard = 0; shard < count; ++shard) {
        for (const WorkItem& item : items_of_shard(items, order, {shard, count})) {
          EXPECT_TRUE(seen.emplace(item.scene, item.conversation).second);
          shards_of_scene[item.scene].insert(shard);
        }
      }
      EXPECT_EQ(seen.size(), items.size());
      if (scenes < count) continue;
      for (const auto& [scene, shards] : shards_of_scene) EXPECT_EQ(shards.size(), 1U);
    }
  }
}

TEST(WorkPlan, ShardsAreParsedStrictly) {
  EXPECT_EQ(parse_shard("3/8").index, 3);
  EXPECT_EQ(parse_shard("3/8").count, 8);
  for (const char* text : {"", "3", "8/8", "-1/8", "1/0", "1/8x", "a/b", "1/"}) {
    EXPECT_THROW(parse_shard(text), InputError) << text;
  }
}

}  // namespace
}  // namespace earpoint
