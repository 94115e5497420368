#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <earpoint/evaluate/evaluation_table.h>

namespace earpoint {
namespace {

/// Three clips of two conversations, two methods; the second has no LRE of the last clip.
EvaluationResult three_clips() {
  EvaluationResult result;
  result.methods = {{"input", "as it is", false, 0}, {"mine", "mine.safetensors", false, 1}};
  const double mags[3][2] = {{4.0, 1.0}, {2.0, 2.0}, {6.0, 3.0}};
  for (int i = 0; i < 3; ++i) {
    ClipResult clip;
    clip.cluster = i / 2;
    for (int m = 0; m < 2; ++m) {
      ClipMetrics metrics;
      metrics[Metric::mag] = mags[i][m];
      if (i < 2 || m == 0) metrics[Metric::lre] = 1.0 + i + m;
      clip.honest.push_back(metrics);
      metrics[Metric::mag] = 0.5 * mags[i][m];
      clip.released.push_back(metrics);
    }
    result.clips.push_back(clip);
  }
  result.skipped = {{"clip 9", "a.wav: is empty"}};
  return result;
}

TEST(EvaluationTable, MeansAndRatiosAreOverClips) {
  const EvaluationTable table = make_table(three_clips());
  EXPECT_EQ(table.clips, 3U);
  EXPECT_EQ(table.conversations, 2U);
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_DOUBLE_EQ(table.rows[0][Metric::mag].mean->value, 4.0);
  EXPECT_DOUBLE_EQ(table.rows[1][Metric::mag].mean->value, 2.0);
  EXPECT_DOUBLE_EQ(table.rows[1][Metric::mag].ratio->value, 0.5);
  EXPECT_DOUBLE_EQ(table.rows[1][Metric::mag].released->value, 1.0);
  // Two conversations: a replicate has one of them twice, or both.
  EXPECT_DOUBLE_EQ(table.rows[1][Metric::mag].mean->range->low, 1.5);
  EXPECT_DOUBLE_EQ(table.rows[1][Metric::mag].mean->range->high, 3.0);
  // Over the two clips that have both values: (2 + 3) / (1 + 2).
  EXPECT_DOUBLE_EQ(table.rows[1][Metric::lre].ratio->value, 5.0 / 3.0);
  EXPECT_EQ(table.rows[1][Metric::lre].mean->clips, 2U);
  EXPECT_FALSE(table.rows[1][Metric::rte].mean.has_value());
}

TEST(EvaluationTable, WithoutInputThereIsNoRatio) {
  EvaluationResult result = three_clips();
  result.methods[0].name = "copy";
  EXPECT_FALSE(make_table(result).rows[1][Metric::mag].ratio.has_value());
}

TEST(EvaluationTable, JsonIsTheContract) {
  const auto json =
      nlohmann::json::parse(json_of(make_table(three_clips()), {"data/x", "test", "pairs-test.json",
                                                                PairTarget::viewpoint, -40.0}));
  EXPECT_EQ(json.at("data"), "data/x");
  EXPECT_EQ(json.at("split"), "test");
  EXPECT_EQ(json.at("target"), "viewpoint");
  EXPECT_EQ(json.at("ambient_db"), -40.0);
  EXPECT_EQ(json.at("pairs"), "pairs-test.json");
  EXPECT_EQ(json.at("clips"), 3);
  EXPECT_EQ(json.at("conversations"), 2);
  EXPECT_EQ(json.at("homes"), 1);
  EXPECT_TRUE(json.at("voices").is_null());
  EXPECT_EQ(json.at("intervals_by"), "conversation");
  EXPECT_EQ(json.at("skipped")[0].at("problem"), "a.wav: is empty");
  const auto& row = json.at("rows")[1];
  EXPECT_EQ(row.at("method"), "mine");
  EXPECT_EQ(row.at("is_oracle"), false);
  EXPECT_EQ(row.at("mag").at("mean"), 2.0);
  EXPECT_EQ(row.at("mag").at("low"), 1.5);
  EXPECT_EQ(row.at("mag").at("high"), 3.0);
  EXPECT_EQ(row.at("mag").at("clips"), 3);
  EXPECT_EQ(row.at("mag").at("ratio").at("value"), 0.5);
  EXPECT_EQ(row.at("released").at("mag").at("mean"), 1.0);
  EXPECT_EQ(row.at("released").at("sign_fixes"), 1);
  // A metric that was not measured has no key.
  EXPECT_FALSE(row.contains("rte_s"));
}

TEST(EvaluationTable, TextShowsWhatThereIs) {
  const std::string text = text_of(make_table(three_clips()));
  EXPECT_NE(text.find("2.0000 [1.5000, 3.0000]"), std::string::npos) << text;
  EXPECT_NE(text.find("LRE, dB"), std::string::npos) << text;
  EXPECT_EQ(text.find("RTE"), std::string::npos) << text;
  EXPECT_NE(text.find("3 clips of 2 conversations"), std::string::npos) << text;
}

TEST(EvaluationTable, IntervalsAreDrawnByHomeWhereThereAreSeveral) {
  // Two homes with four conversations each; all conversations of a home share its effect on Mag.
  EvaluationResult result;
  result.methods = {{"input", "as it is", false, 0}};
  for (int i = 0; i < 8; ++i) {
    ClipResult clip;
    clip.cluster = i;
    clip.scene = i < 4 ? "home-1" : "home-2";
    clip.voice = i % 3 == 0 ? "1089" : "61";
    ClipMetrics metrics;
    metrics[Metric::mag] = i < 4 ? 1.0 : 3.0;
    clip.honest = {metrics};
    clip.released = {metrics};
    result.clips.push_back(clip);
  }
  const EvaluationTable table = make_table(result);
  EXPECT_EQ(table.homes, 2U);
  EXPECT_EQ(table.conversations, 8U);
  EXPECT_EQ(table.voices, 2U);
  // Half of all replicates have one of the homes twice, which gives both ends of the interval.
  EXPECT_DOUBLE_EQ(table.rows[0][Metric::mag].mean->range->low, 1.0);
  EXPECT_DOUBLE_EQ(table.rows[0][Metric::mag].mean->range->high, 3.0);
  const std::string text = text_of(table);
  EXPECT_NE(text.find("8 clips of 8 conversations in 2 homes, 2 voices"), std::string::npos)
      << text;
  EXPECT_NE(text.find("drawn by home"), std::string::npos) << text;
  const auto json = nlohmann::json::parse(json_of(table, {}));
  EXPECT_EQ(json.at("intervals_by"), "home");
  EXPECT_EQ(json.at("voices"), 2);
}

TEST(EvaluationTable, AMeanOverFewerClipsHasAStar) {
  const std::string text = text_of(make_table(three_clips()));
  // `mine` has no LRE of the last clip; `input` has all.
  EXPECT_NE(text.find("2.500*"), std::string::npos) << text;
  EXPECT_NE(text.find("* mean over fewer clips, those that have a value: LRE 2 of 3."),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("3.0000]*"), std::string::npos) << text;
}

}  // namespace
}  // namespace earpoint
