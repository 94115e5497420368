#include "test_study.h"

#include <csignal>

#include <sys/wait.h>

#include <earpoint/core/file.h>
#include <earpoint/error.h>
#include <earpoint/study/answer_store.h>

namespace earpoint {
namespace {

const std::function<std::string(int)> kPlan = [](int number) {
  return fmt::format("plan {}", number);
};

TEST(AnswerStore, GivesBackWhatItWasTold) {
  const TestFolder folder;
  const auto file = folder.path() / "answers.sqlite";
  std::string id;
  {
    AnswerStore store(file, "study");
    const Participant participant = store.add("p\"1", "", kPlan).value();
    id = participant.id;
    EXPECT_EQ(participant.number, 1);
    EXPECT_TRUE(store.add_answer(id, 0, 0, "{\"choice\":1}", 2.5));
    EXPECT_TRUE(store.add_answer(id, 1, 0, "{}", 0.0));
    EXPECT_TRUE(store.add_answer(id, 0, 1, "{\"choice\":2}", 1.0));
    EXPECT_TRUE(store.finish(id, "thanks; '--"));
    EXPECT_FALSE(store.finish(id, "again"));
  }
  const AnswerStore store = AnswerStore::open_to_read(file, "study");
  const Participant participant = store.find(id).value();
  EXPECT_EQ(participant.label, "p\"1");
  EXPECT_EQ(participant.plan, "plan 1");
  EXPECT_EQ(participant.comment, "thanks; '--");
  EXPECT_TRUE(participant.passed_headphones);
  EXPECT_EQ(participant.finished.size(), 20U);
  const std::vector<Answer> answers = store.answers(id);
  ASSERT_EQ(answers.size(), 2U);
  EXPECT_EQ(answers[0].content, "{\"choice\":2}");
  EXPECT_EQ(answers[0].revision, 1);
  EXPECT_EQ(store.answers(id, true).size(), 3U);
  EXPECT_FALSE(store.find(std::string(32, '0')));
}

TEST(AnswerStore, TakesEveryRevisionOnceAndInOrder) {
  const TestFolder folder;
  AnswerStore store(folder.path() / "answers.sqlite", "study");
  const std::string id = store.add("", "", kPlan)->id;
  EXPECT_FALSE(store.add_answer(id, 0, 1, "{}", 0.0));
  EXPECT_TRUE(store.add_answer(id, 0, 0, "{}", 0.0));
  EXPECT_FALSE(store.add_answer(id, 0, 0, "{}", 0.0));
  EXPECT_TRUE(store.add_answer(id, 0, 1, "{}", 0.0));
}

TEST(AnswerStore, NobodyTakesPartTwiceUnlessTheHeadphonesFailed) {
  const TestFolder folder;
  AnswerStore store(folder.path() / "answers.sqlite", "study");
  const std::string first = store.add("somebody", "", kPlan)->id;
  EXPECT_FALSE(store.add("somebody", "", kPlan));
  EXPECT_TRUE(store.add("", "", kPlan));
  EXPECT_TRUE(store.add("", "", kPlan));
  store.fail_headphones(first);
  EXPECT_EQ(store.add("somebody", "", kPlan)->number, 4);
  EXPECT_EQ(store.participants().size(), 4U);
}

TEST(AnswerStore, RefusesAnswersToAnotherStudyAndOtherFiles) {
  const TestFolder folder;
  const auto file = folder.path() / "answers.sqlite";
  EXPECT_THROW((void)AnswerStore::open_to_read(file, "study"), InputError);
  { const AnswerStore store(file, "study"); }
  EXPECT_THROW(AnswerStore(file, "study, changed"), InputError);
  EXPECT_THROW((void)AnswerStore::open_to_read(file, "study, changed"), InputError);
  EXPECT_NO_THROW(AnswerStore(file, "study"));
  write_file(folder.path() / "text.sqlite", std::string_view("no database at all, but text"));
  EXPECT_THROW(AnswerStore(folder.path() / "text.sqlite", "study"), InputError);
}

TEST(AnswerStore, NoAnswerIsLostWhenItsProcessIsKilled) {
  const TestFolder folder;
  const auto file = folder.path() / "answers.sqlite";
  constexpr int kAnswers = 40;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    AnswerStore store(file, "study");
    const std::string id = store.add("killed", "", kPlan)->id;
    for (int i = 0; i < kAnswers; ++i) store.add_answer(id, i, 0, "{}", 0.0);
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  AnswerStore store(file, "study");
  ASSERT_EQ(store.participants().size(), 1U);
  EXPECT_EQ(store.answers(store.participants()[0].id).size(), static_cast<std::size_t>(kAnswers));
}

}  // namespace
}  // namespace earpoint
