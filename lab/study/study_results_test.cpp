#include "test_study.h"

#include <algorithm>
#include <functional>

#include <nlohmann/json.hpp>

#include <earpoint/study/study_plan.h>
#include <earpoint/study/study_report.h>
#include <earpoint/study/study_results.h>

namespace earpoint {
namespace {

using nlohmann::json;

/// A study without files, for invented answers.
Study bare_study(StudyDesign design, int clips, int controls = 0) {
  Study study;
  study.design = design;
  study.title = "A <study>";
  study.data = "tiny";
  study.methods = {{"input", "", true}, {"dsp", "", true}, {"gtf", "", false}};
  std::vector<StudySound> methods{
      {.condition = "input"}, {.condition = "dsp"}, {.condition = "gtf"}};
  std::vector<StudySound> control{
      {.condition = "truth"}, {.condition = "swapped"}, {.condition = "mono"}};
  if (design == StudyDesign::mushra) {
    methods.insert(methods.end(), control.begin(), control.end());
  }
  for (int i = 0; i < clips + controls; ++i) {
    const bool is_control = i >= clips;
    study.clips.push_back({.id = fmt::format("{:02}", i),
                           .pair = "a pair, with a comma",
                           .sounds = is_control ? control : methods,
                           .is_control = is_control});
  }
  study.training = {.id = "training", .sounds = methods};
  for (int i = 0; i < 6; ++i) study.headphones.push_back({"", i % 3});
  return study;
}

class StudyResultsTest : public testing::Test {
 protected:
  using Choose = std::function<std::string(const StudyStep&)>;
  using Rate = std::function<double(const StudyStep&, const std::string& condition)>;

  std::string add(const std::string& simulated = "") {
    return store_
        .add("", simulated, [&](int number) { return text_of(plan_steps(study_, number)); })
        ->id;
  }
  void answer_all(const std::string& id, const std::function<json(const StudyStep&)>& content,
                  bool finish = true) {
    const std::vector<StudyStep> steps = parse_steps(store_.find(id)->plan);
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const json given =
          steps[i].kind == StudyStep::Kind::headphones ? json{{"choice", 0}} : content(steps[i]);
      store_.add_answer(id, static_cast<int>(i), 0, given.dump(), 1.5);
    }
    if (finish) store_.finish(id, "");
  }
  /// Controls are found, unless `choose` says otherwise.
  std::string choose(const Choose& choose, const std::string& simulated = "", bool finish = true) {
    const std::string id = add(simulated);
    answer_all(
        id,
        [&](const StudyStep& step) {
          const std::string chosen = choose(step);
          const auto place = std::ranges::find(step.order, chosen) - step.order.begin();
          return json{{"choice", place}, {"condition", chosen}};
        },
        finish);
    return id;
  }
  void rate(const Rate& rating) {
    answer_all(add(), [&](const StudyStep& step) {
      json ratings = json::array();
      for (const std::string& condition : step.order) ratings.push_back(rating(step, condition));
      return json{{"ratings", ratings}, {"conditions", step.order}};
    });
  }
  static bool is_control(const StudyStep& step) {
    return std::ranges::find(step.order, "truth") != step.order.end();
  }
  std::vector<StudyGroup> results() { return study_results(study_, store_); }

  TestFolder folder_;
  Study study_ = bare_study(StudyDesign::choice, 10, 2);
  AnswerStore store_{folder_.path() / "answers.sqlite", "study"};
};

TEST_F(StudyResultsTest, SharesAreThoseOfTheAnswers) {
  // Two participants choose gtf, one input on 4 of 10 clips and gtf on the others.
  const Choose gtf = [](const StudyStep& step) { return is_control(step) ? "truth" : "gtf"; };
  choose(gtf);
  choose(gtf);
  choose([&](const StudyStep& step) { return step.item < "04" ? "input" : gtf(step); });
  const StudyGroup people = results().at(0);
  EXPECT_EQ(people.name, "people");
  EXPECT_EQ(people.counted, 3U);
  EXPECT_EQ(people.answers, 30U);
  EXPECT_DOUBLE_EQ(people.rows[0].value->value, 4.0 / 30.0);
  EXPECT_DOUBLE_EQ(people.rows[1].value->value, 0.0);
  EXPECT_DOUBLE_EQ(people.rows[2].value->value, 26.0 / 30.0);
  EXPECT_LT(people.rows[2].value->range->low, 26.0 / 30.0);
  // Nobody chose dsp: none of three independent answers.
  EXPECT_DOUBLE_EQ(people.rows[1].value->range->low, 0.0);
  EXPECT_NEAR(people.rows[1].value->range->high, 1.0 - std::pow(0.025, 1.0 / 3.0), 1e-9);
  double sum = 0.0;
  for (const double share : people.by_place) sum += share;
  EXPECT_NEAR(sum, 1.0, 1e-9);

  ASSERT_EQ(people.comparisons.size(), 2U);
  const StudyComparison& comparison = people.comparisons[0];
  EXPECT_EQ(comparison.baseline, "input");
  EXPECT_EQ(comparison.by_answer.wins, 26);
  EXPECT_EQ(comparison.by_answer.losses, 4);
  EXPECT_EQ(comparison.by_participant.wins, 3);  // 6 to 4 is a vote for gtf
  EXPECT_EQ(comparison.by_clip.wins, 10);
  EXPECT_NEAR(comparison.by_participant.p, 0.25, 1e-9);
  EXPECT_FALSE(comparison.by_participant.detectable);
  EXPECT_EQ(people.comparisons[1].by_answer.ties, 4);  // input was chosen
}

TEST_F(StudyResultsTest, SimulatedParticipantsAreNeverCountedAsPeople) {
  const Choose gtf = [](const StudyStep& step) { return is_control(step) ? "truth" : "gtf"; };
  const Choose dsp = [](const StudyStep& step) { return is_control(step) ? "truth" : "dsp"; };
  choose(gtf);
  choose(dsp, "mag");
  choose(dsp, "level");
  const std::vector<StudyGroup> groups = results();
  ASSERT_EQ(groups.size(), 3U);
  EXPECT_EQ(groups[0].name, "people");
  EXPECT_DOUBLE_EQ(groups[0].rows[2].value->value, 1.0);
  EXPECT_EQ(groups[0].participants.size(), 1U);
  for (const std::size_t g : {1, 2}) {
    EXPECT_TRUE(groups[g].is_simulated);
    EXPECT_DOUBLE_EQ(groups[g].rows[1].value->value, 1.0);
  }
  EXPECT_EQ(groups[1].name, "simulated: level");
  EXPECT_NE(text_of(study_, groups).find("NOT PEOPLE, simulated: mag"), std::string::npos);
  const json told = json::parse(json_of(study_, groups));
  EXPECT_TRUE(told["groups"][1]["simulated"].get<bool>());
  EXPECT_FALSE(told["groups"][0]["simulated"].get<bool>());
}

TEST_F(StudyResultsTest, LeavesOutWhoFailedDidNotFinishOrMissedControls) {
  const Choose gtf = [](const StudyStep& step) { return is_control(step) ? "truth" : "gtf"; };
  choose(gtf);
  choose(gtf, "", false);
  store_.fail_headphones(choose(gtf));
  choose([&](const StudyStep& step) { return step.item == "11" ? "mono" : gtf(step); });
  const StudyGroup people = results().at(0);
  EXPECT_EQ(people.counted, 1U);
  EXPECT_EQ(people.answers, 10U);
  EXPECT_EQ(people.participants[0].left_out, "");
  EXPECT_EQ(people.participants[1].left_out, "did not finish");
  EXPECT_EQ(people.participants[2].left_out, "failed the headphone check");
  EXPECT_EQ(people.participants[3].left_out, "missed the reference in 1 of 2 controls");
  EXPECT_EQ(people.rows[2].value->clips, 10U);
  EXPECT_EQ(people.rows[2].before_screening->clips, 20U);
}

TEST_F(StudyResultsTest, ScreensRatingsByTheRulesOfTheRecommendation) {
  study_ = bare_study(StudyDesign::mushra, 10);
  const Rate good = [](const StudyStep&, const std::string& condition) {
    return condition == "truth" ? 95.0 : condition == "gtf" ? 80.0 : 30.0;
  };
  for (int i = 0; i < 6; ++i) rate(good);
  // The hidden reference below 90 on 3 of 20 pages is allowed, on 4 is not.
  for (const std::string most : {"03", "04"}) {
    rate([&](const StudyStep& step, const std::string& condition) {
      const bool is_missed = condition == "truth" && step.scale == "timbre" && step.item < most;
      return is_missed ? 50.0 : good(step, condition);
    });
  }
  // The anchor of exchanged ears above 90 on 2 of 10 pages of place, or of timbre.
  for (const std::string scale : {"place", "timbre"}) {
    rate([&](const StudyStep& step, const std::string& condition) {
      const bool is_missed = condition == "swapped" && step.scale == scale && step.item < "02";
      return is_missed ? 95.0 : good(step, condition);
    });
  }
  const StudyGroup people = results().at(0);
  EXPECT_EQ(people.counted, 8U);
  EXPECT_EQ(people.participants[6].left_out, "");
  EXPECT_NE(people.participants[7].left_out.find("hidden reference below 90 on 4 of 20"),
            std::string::npos);
  EXPECT_NE(people.participants[8].left_out.find("swapped above 90 on 2 of 10"), std::string::npos);
  EXPECT_EQ(people.participants[9].left_out, "");
  const auto place_of_gtf = std::ranges::find_if(people.rows, [](const StudyRow& row) {
    return row.condition == "gtf" && row.scale == "place";
  });
  EXPECT_DOUBLE_EQ(place_of_gtf->value->value, 80.0);
}

TEST_F(StudyResultsTest, AnAnchorThatIsHardToTellIsHeldAgainstNobody) {
  study_ = bare_study(StudyDesign::mushra, 10);
  for (int i = 0; i < 4; ++i) {
    rate([](const StudyStep& step, const std::string& condition) {
      if (condition == "truth") return 100.0;
      return condition == "mono" && step.item < "03" ? 95.0 : 20.0;
    });
  }
  EXPECT_EQ(results().at(0).counted, 4U);
}

TEST_F(StudyResultsTest, ReportsAreWrittenInAllForms) {
  choose([](const StudyStep& step) { return is_control(step) ? "truth" : "gtf"; });
  const std::vector<StudyGroup> groups = results();
  const std::string csv = answers_csv(study_, groups);
  EXPECT_EQ(std::ranges::count(csv, '\n'), 1 + 12 * 3);
  EXPECT_NE(csv.find("\"a pair, with a comma\""), std::string::npos);
  write_study_report(folder_.path() / "report", study_, groups);
  for (const char* file : {"index.html", "answers.csv", "results.json"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "report" / file)) << file;
  }
  EXPECT_NE(text_of(study_, {}).find("Nobody"), std::string::npos);
}

}  // namespace
}  // namespace earpoint
