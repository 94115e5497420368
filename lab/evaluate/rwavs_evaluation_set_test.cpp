#include <filesystem>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/progress.h>
#include <earpoint/core/temporary_folder.h>
#include <earpoint/dataset_testing/tiny_published.h>
#include <earpoint/evaluate/evaluation.h>
#include <earpoint/evaluate/evaluation_set.h>
#include <earpoint/evaluate/method.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class RwavsEvaluationSetTest : public ::testing::Test {
 protected:
  void SetUp() override { write_tiny_rwavs(root_); }
  TemporaryFolder folder_;
  fs::path root_ = folder_.path();
};

TEST_F(RwavsEvaluationSetTest, HasEveryPoseWithItsSceneAsCluster) {
  const auto set = rwavs_evaluation_set(root_, "val", {});
  ASSERT_EQ(set->size(), 4U);
  EXPECT_EQ(set->name(1), "scene 1, 8 s");
  EXPECT_EQ(set->scene(2), "2");
  EXPECT_NE(set->cluster(1), set->cluster(2));
  EXPECT_TRUE(set->knows_speaker());
  EXPECT_FALSE(set->truth(0).has_value());
  EXPECT_EQ(rwavs_evaluation_set(root_, "val", 2)->size(), 2U);
}

TEST_F(RwavsEvaluationSetTest, HeadFiltersFindTheEarOnTheSpeakersSide) {
  const auto set = rwavs_evaluation_set(root_, "val", {});
  SilentProgress silent;
  const std::vector<MethodEntry> methods{input_method(), dsp_method()};
  const EvaluationResult result = evaluate(*set, methods, {}, silent);
  ASSERT_EQ(result.clips.size(), 4U);
  for (const ClipResult& clip : result.clips) {
    // The dry sound is alike in both ears, and one ear is 6 dB louder than the other there.
    EXPECT_NEAR(clip.honest[0][Metric::lre].value(), 6.0, 0.5);
    EXPECT_LT(clip.honest[1][Metric::lre].value(), clip.honest[0][Metric::lre].value());
  }
}

}  // namespace
}  // namespace earpoint
