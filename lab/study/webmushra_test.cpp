#include "test_study.h"

#include <earpoint/study/webmushra.h>

namespace earpoint {
namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++found;
  }
  return found;
}

TEST(Webmushra, HasAPageForEveryClipAndScale) {
  const TestFolder folder;
  const Study study = copy_test_study(folder.path(), StudyDesign::mushra);
  const std::string yaml = webmushra_yaml(study, "configs/study");
  EXPECT_EQ(count(yaml, "type: mushra"), 2U * 7U);
  EXPECT_EQ(count(yaml, "- random"), 2U);
  EXPECT_EQ(count(yaml, "reference: \"configs/study/clips/01/reference.wav\""), 2U);
  EXPECT_EQ(count(yaml, "\"mono\": \"configs/study/clips/01/mono.wav\""), 2U);
  // WebMUSHRA adds the reference itself.
  EXPECT_EQ(yaml.find("truth"), std::string::npos);
}

TEST(Webmushra, ComparesPairsWhereTheDesignIsAChoice) {
  const TestFolder folder;
  const Study study = copy_test_study(folder.path(), StudyDesign::choice);
  const std::string yaml = webmushra_yaml(study, "configs/study");
  EXPECT_EQ(count(yaml, "type: paired_comparison"), 7U);
  EXPECT_EQ(yaml.find("control"), std::string::npos);
}

}  // namespace
}  // namespace earpoint
