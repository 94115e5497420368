#include <filesystem>
#include <set>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/dataset/pair_list.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

std::vector<SoundSpacesClip> clips_of(const std::vector<std::string>& scenes) {
  std::vector<SoundSpacesClip> clips;
  for (const std::string& scene : scenes) {
    for (int index = 0; index < 5; ++index) {
      SoundSpacesClip& clip = clips.emplace_back();
      clip.scene = scene;
      clip.index = index;
      clip.viewpoints.resize(4);
      for (int id = 0; id < 3; ++id) {
        clip.speakers.emplace_back().id = id;
      }
      clip.speakers[0].speech = "a-0-0";
      clip.speakers[2].speech = "b-0-0";
    }
  }
  return clips;
}

std::ptrdiff_t samples_of(const std::string& speech) { return speech == "a-0-0" ? 20000 : 9000; }

TEST(PairList, EveryViewpointIsTheTargetOnceAndSpeakersHaveSpeech) {
  const auto clips = clips_of({"home"});
  const PairList list = draw_pair_list("test", clips, samples_of, 1);
  ASSERT_EQ(list.pairs.size(), 20U);
  std::set<std::pair<int, int>> targets;
  bool late_window = false;
  for (const ViewPair& pair : list.pairs) {
    targets.emplace(pair.clip, pair.choice.target);
    EXPECT_NE(pair.choice.source, pair.choice.target);
    EXPECT_NE(pair.choice.speaker, 1);
    // A window lies within its speech if that is long enough, otherwise at its start.
    EXPECT_LE(pair.choice.window_start, pair.choice.speaker == 0 ? 4000 : 0);
    late_window = late_window || pair.choice.window_start > 0;
    EXPECT_EQ(&clip_of(pair, clips, "list"), &clips[pair.clip]);
  }
  EXPECT_EQ(targets.size(), 20U);
  EXPECT_TRUE(late_window);
}

TEST(PairList, AClipsPairsDoNotDependOnOtherClips) {
  const PairList alone = draw_pair_list("test", clips_of({"home"}), samples_of, 1);
  const PairList among = draw_pair_list("test", clips_of({"flat", "home"}), samples_of, 1);
  for (std::size_t i = 0; i < alone.pairs.size(); ++i) {
    EXPECT_EQ(alone.pairs[i].choice.source, among.pairs[20 + i].choice.source);
    EXPECT_EQ(alone.pairs[i].choice.window_start, among.pairs[20 + i].choice.window_start);
  }
}

class PairListFile : public ::testing::Test {
 protected:
  void TearDown() override { fs::remove(path_); }

  [[nodiscard]] std::string error_of(const std::string& text) const {
    write_file(path_, text);
    try {
      static_cast<void>(read_pair_list(path_));
    } catch (const InputError& error) {
      const std::string message = error.what();
      return message.substr(message.find(".json"));
    }
    return "none";
  }

  fs::path path_ = fs::path(testing::TempDir()) /
                   (std::string("pairs_") +
                    testing::UnitTest::GetInstance()->current_test_info()->name() + ".json");
};

TEST_F(PairListFile, IsReadAsItWasWritten) {
  const PairList list = draw_pair_list("val", clips_of({"home"}), samples_of, 3);
  write_file(path_, text_of(list));
  const PairList read = read_pair_list(path_);
  EXPECT_EQ(read.split, "val");
  EXPECT_EQ(text_of(read), text_of(list));
}

TEST_F(PairListFile, ErrorsNameTheField) {
  EXPECT_EQ(error_of("["), ".json: is not valid JSON");
  EXPECT_EQ(error_of(R"({"format": "earpoint-pairs-9"})"),
            ".json: expected format earpoint-pairs-1, found earpoint-pairs-9");
  EXPECT_EQ(error_of(R"({"format": "earpoint-pairs-1", "split": "test", "pairs": [{}]})"),
            ".json: pairs[0]: the field 'scene' is missing");
}

TEST_F(PairListFile, APairOfAnotherDataSetIsRefused) {
  const auto clips = clips_of({"home"});
  ViewPair pair{.scene = "flat", .clip = 0, .choice = {.source = 0, .target = 1}};
  EXPECT_THROW(static_cast<void>(clip_of(pair, clips, "list")), InputError);
  pair.scene = "home";
  EXPECT_NO_THROW(static_cast<void>(clip_of(pair, clips, "list")));
  pair.choice.target = 4;
  EXPECT_THROW(static_cast<void>(clip_of(pair, clips, "list")), InputError);
  pair.choice = {.source = 0, .target = 1, .speaker = 1};
  EXPECT_THROW(static_cast<void>(clip_of(pair, clips, "list")), InputError);
}

}  // namespace
}  // namespace earpoint
