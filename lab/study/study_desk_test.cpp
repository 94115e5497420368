#include "test_study.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include <earpoint/core/file.h>
#include <earpoint/study/study_desk.h>

namespace earpoint {
namespace {

using nlohmann::json;

class StudyDeskTest : public testing::Test {
 protected:
  void SetUp() override {
    study_ = copy_test_study(folder_.path(), StudyDesign::choice);
    open();
  }
  void open() {
    desk_.reset();
    desk_ = std::make_unique<StudyDesk>(folder_.path() / "study");
  }
  std::string join(const std::string& body = "") {
    return json::parse(desk_->join(body).body)["participant"];
  }
  DeskReply choose(const std::string& id, std::size_t step, int choice, int revision = 0) {
    return desk_->answer(id, step, json{{"choice", choice}, {"revision", revision}}.dump());
  }
  json state(const std::string& id) { return json::parse(desk_->state(id).body); }
  /// What a listener with headphones answers.
  int quietest(const std::string& id, std::size_t step) {
    const auto file = desk_->sound_file(id, step, "0").value();
    for (const HeadphoneTrial& trial : study_.headphones) {
      if (file == folder_.path() / "study" / trial.file) return trial.quietest;
    }
    return -1;
  }
  void pass_headphones(const std::string& id) {
    for (std::size_t i = 0; i < kHeadphoneTrials; ++i) choose(id, i, quietest(id, i));
  }

  TestFolder folder_;
  Study study_;
  std::unique_ptr<StudyDesk> desk_;
};

TEST_F(StudyDeskTest, LeadsThroughTheStudyOnce) {
  const std::string id = join();
  const std::size_t steps = state(id)["steps"].size();
  ASSERT_EQ(steps, kHeadphoneTrials + 1 + 8);
  pass_headphones(id);
  for (std::size_t i = kHeadphoneTrials; i < steps; ++i) {
    EXPECT_EQ(state(id)["at"], i);
    EXPECT_EQ(desk_->finish(id, "").status, 409);
    EXPECT_EQ(choose(id, i, 1).status, 200);
  }
  EXPECT_EQ(desk_->finish(id, R"({"comment": "fine"})").status, 200);
  EXPECT_EQ(desk_->finish(id, "").status, 409);
  EXPECT_EQ(choose(id, steps - 1, 2, 1).status, 409);
  EXPECT_TRUE(state(id)["finished"]);
}

TEST_F(StudyDeskTest, RefusesTheSameAnswerTwiceAndTakesAChange) {
  const std::string id = join();
  pass_headphones(id);
  EXPECT_EQ(choose(id, 6, 0).status, 200);
  EXPECT_EQ(choose(id, 6, 0).status, 409);
  EXPECT_EQ(choose(id, 6, 2, 2).status, 409);
  EXPECT_EQ(choose(id, 6, 2, 1).status, 200);
  EXPECT_EQ(state(id)["steps"][6]["choice"], 2);
  EXPECT_EQ(state(id)["at"], 7);
  EXPECT_EQ(choose(id, 8, 0).status, 409);  // 7 comes first
  EXPECT_EQ(choose(id, 99, 0).status, 404);
}

TEST_F(StudyDeskTest, GoesOnAfterARestart) {
  const std::string id = join();
  pass_headphones(id);
  choose(id, 6, 1);
  choose(id, 7, 2);
  const json before = state(id);
  open();
  EXPECT_EQ(state(id), before);
  EXPECT_EQ(before["at"], 8);
  EXPECT_EQ(before["steps"][7]["choice"], 2);
}

TEST_F(StudyDeskTest, FiveOfSixTonesPassAndFourDoNot) {
  for (const int wrong : {1, 2}) {
    const std::string id = join();
    for (std::size_t i = 0; i < kHeadphoneTrials; ++i) {
      const int right = quietest(id, i);
      const bool is_wrong = i < static_cast<std::size_t>(wrong);
      EXPECT_EQ(choose(id, i, is_wrong ? (right + 1) % 3 : right).status, 200);
    }
    EXPECT_EQ(state(id)["passed_headphones"], wrong == 1);
    EXPECT_EQ(choose(id, 6, 0).status, wrong == 1 ? 200 : 409);
  }
  const std::string id = join();
  choose(id, 0, 0);
  EXPECT_EQ(choose(id, 0, 1, 1).status, 409);  // the check is final
}

TEST_F(StudyDeskTest, TellsNeitherMethodsNorWhatIsRight) {
  const std::string id = join();
  pass_headphones(id);
  choose(id, 6, 0);
  const std::string told = desk_->state(id).body + desk_->study().body;
  for (const char* word : {"input", "exchanged", "left", "truth", "quietest", "control", ".wav"}) {
    EXPECT_EQ(told.find(word), std::string::npos) << word << " in " << told;
  }
}

TEST_F(StudyDeskTest, GivesTheSoundsInTheOrderOfTheParticipant) {
  const std::string id = join();
  std::vector<std::string> heard;
  for (const char* sound : {"0", "1", "2"}) {
    heard.push_back(desk_->sound_file(id, 8, sound)->stem().string());
  }
  std::ranges::sort(heard);
  EXPECT_EQ(std::ranges::unique(heard).size(), 0U);
  EXPECT_EQ(desk_->sound_file(id, 8, "reference")->stem(), "reference");
  EXPECT_EQ(desk_->picture_file(id, 8)->extension(), ".png");
  for (const char* sound : {"3", "-1", "", "truth", "0x", "../study.json"}) {
    EXPECT_FALSE(desk_->sound_file(id, 8, sound)) << sound;
  }
  EXPECT_FALSE(desk_->picture_file(id, 0));
  EXPECT_FALSE(desk_->sound_file(std::string(32, 'a'), 8, "0"));
}

TEST_F(StudyDeskTest, RefusesBadRequestsInALine) {
  const std::string id = join();
  for (const char* body : {"nonsense", "[]", "{}", R"({"choice": 3, "revision": 0})",
                           R"({"choice": -1, "revision": 0})", R"({"choice": 1.5, "revision": 0})",
                           R"({"choice": "1", "revision": 0})", R"({"choice": 1})",
                           R"({"choice": 1, "revision": 0, "seconds": -1})",
                           R"({"choice": 1, "revision": 0, "seconds": "long"})"}) {
    EXPECT_EQ(desk_->answer(id, 0, body).status, 400) << body;
  }
  EXPECT_EQ(state(id)["at"], 0);
  EXPECT_EQ(desk_->join(json{{"label", std::string(100, 'x')}}.dump()).status, 400);
  EXPECT_EQ(desk_->state(std::string(32, '0')).status, 404);
}

TEST_F(StudyDeskTest, ALabelTakesPartOnce) {
  join(R"({"label": "p1"})");
  EXPECT_EQ(desk_->join(R"({"label": "p1"})").status, 409);
  EXPECT_EQ(desk_->join(R"({"label": "p2"})").status, 200);
}

TEST(StudyDesk, RatesEverySoundFrom0To100) {
  const TestFolder folder;
  copy_test_study(folder.path(), StudyDesign::mushra);
  StudyDesk desk(folder.path() / "study");
  const std::string id = json::parse(desk.join("").body)["participant"];
  const Study study = read_study(folder.path() / "study");
  for (std::size_t i = 0; i < kHeadphoneTrials; ++i) {
    const auto file = desk.sound_file(id, i, "0").value();
    const auto trial = std::ranges::find_if(study.headphones, [&](const HeadphoneTrial& t) {
      return file.filename() == std::filesystem::path(t.file).filename();
    });
    desk.answer(id, i, json{{"choice", trial->quietest}, {"revision", 0}}.dump());
  }
  const auto rate = [&](const json& ratings) {
    return desk.answer(id, 6, json{{"ratings", ratings}, {"revision", 0}}.dump()).status;
  };
  EXPECT_EQ(rate({1, 2, 3}), 400);
  EXPECT_EQ(rate({1, 2, 3, 4, 5, 101}), 400);
  EXPECT_EQ(rate({1, 2, 3, 4, 5, "6"}), 400);
  EXPECT_EQ(rate({0, 2, 3, 4, 5.5, 100}), 200);
  const json step = json::parse(desk.state(id).body)["steps"][6];
  EXPECT_EQ(step["ratings"], json({0, 2, 3, 4, 5.5, 100}));
}

}  // namespace
}  // namespace earpoint
