#include "test_study.h"

#include <algorithm>
#include <map>
#include <set>

#include <earpoint/error.h>
#include <earpoint/study/study_plan.h>

namespace earpoint {
namespace {

Study study_of(StudyDesign design, int clips, int controls) {
  Study study;
  study.design = design;
  study.seed = 1;
  study.methods = {{"a", "", true}, {"b", "", false}, {"c", "", false}};
  const std::vector<StudySound> sounds{{.condition = "a"}, {.condition = "b"}, {.condition = "c"}};
  for (int i = 0; i < clips + controls; ++i) {
    study.clips.push_back({.id = fmt::format("{}", i), .sounds = sounds, .is_control = i >= clips});
  }
  study.training = {.id = "training", .sounds = sounds};
  study.headphones.resize(kHeadphoneTrials);
  return study;
}

TEST(StudyPlan, EverybodyGetsEverythingOnceInAnOrderOfTheirOwn) {
  const Study study = study_of(StudyDesign::choice, 6, 2);
  std::set<std::string> plans;
  for (int participant = 1; participant <= 20; ++participant) {
    const std::vector<StudyStep> steps = plan_steps(study, participant);
    ASSERT_EQ(steps.size(), kHeadphoneTrials + 1 + 8);
    std::set<std::string> items;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const auto kind = i < kHeadphoneTrials    ? StudyStep::Kind::headphones
                        : i == kHeadphoneTrials ? StudyStep::Kind::training
                                                : StudyStep::Kind::trial;
      EXPECT_EQ(steps[i].kind, kind);
      EXPECT_TRUE(items.insert(std::string(name_of(steps[i].kind)) + steps[i].item).second);
    }
    EXPECT_FALSE(study.find_clip(steps[kHeadphoneTrials + 1].item)->is_control);
    EXPECT_TRUE(plans.insert(text_of(steps)).second) << "participant " << participant;
    EXPECT_EQ(plan_steps(study, participant), steps);
  }
}

TEST(StudyPlan, EverySoundIsAtEveryPlaceEquallyOften) {
  const Study study = study_of(StudyDesign::choice, 6, 0);
  std::map<std::string, int> first;
  for (int participant = 1; participant <= 200; ++participant) {
    for (const StudyStep& step : plan_steps(study, participant)) {
      if (step.kind == StudyStep::Kind::trial) ++first[step.order.front()];
    }
  }
  ASSERT_EQ(first.size(), 3U);
  // 400 each of 1200; five standard deviations are 82.
  for (const auto& [condition, count] : first) EXPECT_NEAR(count, 400, 82) << condition;
}

TEST(StudyPlan, RatesAllClipsOnOneScaleAndThenOnTheOther) {
  const Study study = study_of(StudyDesign::mushra, 4, 0);
  std::set<std::string> first_scales;
  for (int participant = 1; participant <= 20; ++participant) {
    const std::vector<StudyStep> steps = plan_steps(study, participant);
    ASSERT_EQ(steps.size(), kHeadphoneTrials + 2 * 5);
    const std::string& scale = steps[kHeadphoneTrials].scale;
    first_scales.insert(scale);
    for (std::size_t i = kHeadphoneTrials; i < steps.size(); ++i) {
      EXPECT_EQ(steps[i].scale == scale, i < kHeadphoneTrials + 5);
      EXPECT_EQ(steps[i].kind == StudyStep::Kind::training, (i - kHeadphoneTrials) % 5 == 0);
    }
  }
  EXPECT_EQ(first_scales.size(), 2U);
}

TEST(StudyPlan, IsReadBackAsItWasWritten) {
  for (const StudyDesign design : {StudyDesign::choice, StudyDesign::mushra}) {
    const std::vector<StudyStep> steps = plan_steps(study_of(design, 3, 1), 5);
    EXPECT_EQ(parse_steps(text_of(steps)), steps);
  }
  EXPECT_THROW(parse_steps("nonsense"), InputError);
  EXPECT_THROW(parse_steps(R"([{"kind":"x","item":"","scale":"","order":[]}])"), InputError);
}

}  // namespace
}  // namespace earpoint
